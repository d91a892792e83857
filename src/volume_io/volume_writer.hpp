// Writes fields as volume files. A file gets its name only when it is complete.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::volume_io {

enum class VolumeFileFormat {
  npy,   // NumPy array [z, y, x], or [y, x] for one layer; without spacing and origin
  nrrd,  // attached header with the transform, raw samples
  raw,   // samples only, x fastest
  vdb,   // OpenVDB, by the plug-in (grid_tools.hpp); any number of fields, as floats
  vti,   // VTK image data, XML with appended raw samples; the axes of the samples must be perpendicular
};
constexpr auto words_of(VolumeFileFormat /*type*/) {
  return std::array{Word{VolumeFileFormat::npy, "npy"}, Word{VolumeFileFormat::nrrd, "nrrd"},
                    Word{VolumeFileFormat::raw, "raw"}, Word{VolumeFileFormat::vdb, "vdb"},
                    Word{VolumeFileFormat::vti, "vti"}};
}

// Returns the format for a file's extension, ignoring case.
[[nodiscard]] std::optional<VolumeFileFormat> volume_file_format_by_path(const std::filesystem::path& path);

// Returns whether files of this format can store samples of this type. npy, raw and vdb (as floats) store all types,
// nrrd and vti all but 16-bit floats.
[[nodiscard]] bool can_store(VolumeFileFormat format, field::SampleType type);

// Writes one field or, for vdb, several. Except for vdb, samples must be dense and without a value scale; they
// keep their type, which can_store() must allow, and are in the machine's byte order. Returns the number of
// bytes. Fails with ErrorCode::output if the file cannot be written or its format cannot hold the field, and with
// ErrorCode::input as check_mapping_intact() does; for vdb fails as write_vdb() does.
[[nodiscard]] Result<std::uint64_t> write_volume(const std::filesystem::path& path,
                                                 std::span<const field::ScalarField> fields, VolumeFileFormat format,
                                                 const Context& context);

}  // namespace isoextract::volume_io
