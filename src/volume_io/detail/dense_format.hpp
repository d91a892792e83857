// Base of formats whose files hold one full box of samples with a header. A format parses the header and locates the
// samples; everything else is shared.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "field/scalar_field.hpp"
#include "files/file_bytes.hpp"
#include "volume_io/detail/placement.hpp"
#include "volume_io/detail/sample_source.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// 64-bit integers become double, which is exact up to 2^53 and for some larger integers; an inexact one is an error.
// With ReadOptions::label_ids they become indices into a table of ids instead (label_ids.hpp).
enum class Integer64 { none, i64, u64 };

// One or several dense volumes of equal size with a validated header; samples are not validated.
struct DenseFile {
  std::string format;  // "NRRD"
  std::string world_space;
  std::string length_unit;  // as in ScalarField, like world_space
  field::SampleType type = field::SampleType::u8;
  Integer64 wide = Integer64::none;  // if set, `type` is f64
  glm::ivec3 dims{0};
  std::endian endian = std::endian::native;
  bool x_slowest = false;  // stored with the last axis fastest
  field::ValueScale scale;
  Frame frame;
  std::uint64_t volumes = 1;     // number of volumes of `dims` each; 1 or more
  bool interleaved = false;      // stored sample by sample: the first samples of all volumes, then all second samples;
                                 // else volume by volume
  std::uint64_t components = 1;  // components per sample; 1 or more
  bool components_interleaved = false;   // whether components are stored sample by sample, else component by component
  bool component_before_volume = true;   // components vary faster than volumes, if the spatial axes are not between
                                         // the two
  std::vector<field::LabelName> labels;  // as in ScalarField
  std::string component_names;           // names of the components in order; may be empty
  Hint other_interpretation;             // other interpretation of a file with several volumes; see choose_volume()
  std::vector<SamplePiece> pieces;       // of all volumes and components
  bool size_is_exact = false;            // bytes after the samples are an error instead of a note
  Notes notes;
};

class DenseFormat : public VolumeFormat {
 public:
  using VolumeFormat::VolumeFormat;

  [[nodiscard]] Result<std::vector<GridInfo>> list(const std::string& input, const ReadOptions& options,
                                                   const Context& context) const final;
  [[nodiscard]] Result<std::vector<std::filesystem::path>> files(const std::string& input, const ReadOptions& options,
                                                                 const Context& context) const final;
  [[nodiscard]] Result<std::vector<files::FilePart>> parts(const std::string& input, const ReadOptions& options,
                                                           const Context& context) const final;
  [[nodiscard]] Result<field::ScalarField> open(const std::string& input, const ReadOptions& options,
                                                const Context& context) const final;

 protected:
  // Reads the header. If the header names other files, opens them in the context of `file`.
  [[nodiscard]] virtual Result<DenseFile> open_header(const files::InputFile& file,
                                                      const ReadOptions& options) const = 0;
};

// Returns the description of the only grid.
[[nodiscard]] GridInfo grid_of(const DenseFile& dense, std::string name);

// Converts sizes from a header to dims. Fails if one is 0 or too large for an index, or if the total is more than 2^62
// bytes.
[[nodiscard]] Result<glm::ivec3> checked_dims(const std::string& file, const std::array<std::uint64_t, 3>& sizes,
                                              field::SampleType type);

// Fails if `count` is 0, or `count` volumes of size `dims` have more than 2^62 bytes; components count as volumes.
[[nodiscard]] Result<void> check_volume_count(const std::string& file, const glm::ivec3& dims, field::SampleType type,
                                              std::uint64_t count);

[[nodiscard]] std::uint64_t sample_bytes(const glm::ivec3& dims, field::SampleType type);

// "100x100x100 f32 samples"
[[nodiscard]] std::string describe_samples(const glm::ivec3& dims, field::SampleType type);

// Returns the description of the only grid of a dense volume.
[[nodiscard]] GridInfo dense_grid(std::string name, const glm::ivec3& dims, field::SampleType type);

// Returns a file's name without folder and format extensions.
[[nodiscard]] std::string stem_of(const std::filesystem::path& path);

}  // namespace isoextract::volume_io
