// The door for volumes that are written: fields as files, whole or not at all.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/words.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::volume_io {

enum class VolumeFileFormat {
  npy,   // NumPy's array [z, y, x], of one layer [y, x]; holds no spacing and no origin
  nrrd,  // an attached header with the transform, raw samples
  raw,   // samples alone, x fastest
  vdb,   // OpenVDB, by the plug-in (grid_tools.hpp); any number of fields, as floats
};
constexpr auto words_of(VolumeFileFormat /*type*/) {
  return std::array{Word{VolumeFileFormat::npy, "npy"}, Word{VolumeFileFormat::nrrd, "nrrd"},
                    Word{VolumeFileFormat::raw, "raw"}, Word{VolumeFileFormat::vdb, "vdb"}};
}

// By the extension of a name, upper case or lower.
[[nodiscard]] std::optional<VolumeFileFormat> volume_file_format_by_path(const std::filesystem::path& path);

// One field or, in a vdb, several. Of npy, nrrd and raw the samples are dense, keep their type and are written in the
// machine's byte order; nrrd has none of 16-bit floats. Gives the number of bytes. Fails with ErrorCode::output where
// the file cannot be written or its format does not hold the field, and as write_vdb() does.
[[nodiscard]] Result<std::uint64_t> write_volume(const std::filesystem::path& path,
                                                 std::span<const field::ScalarField> fields, VolumeFileFormat format,
                                                 const Context& context);

}  // namespace isoextract::volume_io
