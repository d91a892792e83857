// The one door to the volume formats; one file per format behind it (vdb_reader.cpp, nrrd_reader.cpp, ...).
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "base/progress.hpp"
#include "base/words.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::volumes {

enum class VolumeFormat { vdb, nrrd, nifti, npy, raw, demo };
constexpr auto words_of(VolumeFormat /*type*/) {
  return std::array{Word{VolumeFormat::vdb, "vdb"},     Word{VolumeFormat::nrrd, "nrrd"},
                    Word{VolumeFormat::nifti, "nifti"}, Word{VolumeFormat::npy, "npy"},
                    Word{VolumeFormat::raw, "raw"},     Word{VolumeFormat::demo, "demo"}};
}

// One row a format: detection, help and README read it.
struct VolumeFormatInfo {
  VolumeFormat format;
  std::string_view name;        // as in --input-format
  std::string_view extensions;  // ".nrrd .nhdr"
  std::string_view title;       // "NRRD, attached or detached, raw or gzip"
};
[[nodiscard]] std::span<const VolumeFormatInfo> volume_formats();

// What a headerless file cannot say of itself.
struct RawLayout {
  glm::ivec3 dims{0};  // x (fastest), y, z
  field::SampleType type = field::SampleType::u8;
  std::endian endian = std::endian::little;
  std::uint64_t skip = 0;  // bytes before the first sample

  friend bool operator==(const RawLayout&, const RawLayout&) = default;
};

struct ReadOptions {
  std::optional<VolumeFormat> format;    // default: by content, then by extension
  std::optional<std::string> grid;       // VDB: NAME or NAME[k], k counts grids of that name from 0
  std::optional<RawLayout> raw;          // raw files need it; for others it is an error
  std::optional<glm::dvec3> spacing;     // replaces what the file says; raw and NPY have 1
  std::optional<glm::dvec3> origin;      // world position of index (0, 0, 0); likewise
  std::optional<field::FieldKind> kind;  // replaces what the file says
  Limits limits = default_limits();
  Progress* progress = nullptr;

  friend bool operator==(const ReadOptions&, const ReadOptions&) = default;
};

// One grid of a file as its header tells, without reading samples.
struct GridInfo {
  std::string name;
  int index_of_name = 0;                 // k of NAME[k]
  bool name_repeats = false;             // true if NAME alone would not be enough
  std::string type;                      // "float", "vec3s", ...
  bool scalar = false;                   // a surface can be extracted from it
  std::optional<field::FieldKind> kind;  // where the file says so
  field::IndexBox box;                   // active voxels, or all samples; may be empty
  std::uint64_t voxels = 0;              // active voxels, or all samples
};

// `input` is a path or demo:NAME. Only VDB files have more than one grid. Never reads samples.
[[nodiscard]] Result<std::vector<GridInfo>> list_grids(const std::string& input, const ReadOptions& options);

// The files that read_volume would read: `input`, and those that hold the samples where its header says so. A file may
// be named twice. Never reads samples.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_input_files(const std::string& input,
                                                                          const ReadOptions& options);

// Reads one grid. Fails with ErrorKind::input (unreadable, unsupported, no such grid; the hint lists the grids where a
// choice is missing or wrong) or ErrorKind::usage (options that do not go with the format).
[[nodiscard]] Result<field::ScalarField> read_volume(const std::string& input, const ReadOptions& options);

}  // namespace isoextract::volumes
