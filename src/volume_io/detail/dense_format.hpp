// Formats whose files hold one full box of samples behind a header: they say what the header says and where the samples
// are; the rest is the same for all.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "files/file_bytes.hpp"
#include "volume_io/detail/placing.hpp"
#include "volume_io/detail/sample_source.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// Integers of 64 bits become doubles, which hold them exactly up to 2^53 and some beyond; one that they do not hold is
// an error.
enum class WideInteger { none, i64, u64 };

// A dense volume, or several of one size, whose header was read and checked; the samples were not.
struct DenseFile {
  std::string format;  // "NRRD"
  std::string world_space;
  std::string length_unit;  // likewise as in ScalarField
  field::SampleType type = field::SampleType::u8;
  WideInteger wide = WideInteger::none;  // f64 is the type of others
  glm::ivec3 dims{0};
  std::endian endian = std::endian::native;
  bool x_slowest = false;  // stored with the last axis fastest
  field::ValueScale scale;
  Frame frame;
  std::uint64_t volumes = 1;     // at least, of `dims` each
  bool interleaved = false;      // the volumes' first samples come first, then their second ones; else one volume first
  std::uint64_t components = 1;  // numbers a sample, at least
  bool components_interleaved = false;  // likewise
  bool component_before_volume = true;  // of two axes on the same side of space, that of the components is the faster
  std::string component_names;          // what they are, in their order; may be empty
  Hint other_reading;                   // what else the file could be than several volumes; see choose_volume()
  std::vector<SamplePiece> pieces;      // of all volumes and components
  bool size_is_exact = false;           // bytes after the samples are an error, not a note
  std::vector<std::string> notes;
};

class DenseFormat : public VolumeFormat {
 public:
  using VolumeFormat::VolumeFormat;

  [[nodiscard]] Result<std::vector<GridInfo>> list(const std::string& input, const ReadOptions& options,
                                                   const Context& context) const final;
  [[nodiscard]] Result<std::vector<std::filesystem::path>> files(const std::string& input, const ReadOptions& options,
                                                                 const Context& context) const final;
  [[nodiscard]] Result<field::ScalarField> open(const std::string& input, const ReadOptions& options,
                                                const Context& context) const final;

 protected:
  // Reads the header. Other files that it names are opened in the context of `file`.
  [[nodiscard]] virtual Result<DenseFile> open_header(const files::InputFile& file,
                                                      const ReadOptions& options) const = 0;
};

// The grid that `dense` is.
[[nodiscard]] GridInfo grid_of(const DenseFile& dense, std::string name);

// Sizes from a header as dims. Fails where one is 0 or too large for an index, or where all together are more than
// 2^62 bytes.
[[nodiscard]] Result<glm::ivec3> checked_dims(const std::string& file, const std::array<std::uint64_t, 3>& sizes,
                                              field::SampleType type);

// Likewise for the number of volumes of that size in one file, components counted as such.
[[nodiscard]] Result<void> check_volume_count(const std::string& file, const glm::ivec3& dims, field::SampleType type,
                                              std::uint64_t count);

[[nodiscard]] std::uint64_t sample_bytes(const glm::ivec3& dims, field::SampleType type);

// "100x100x100 f32 samples"
[[nodiscard]] std::string describe_samples(const glm::ivec3& dims, field::SampleType type);

// The one grid of a dense volume.
[[nodiscard]] GridInfo dense_grid(std::string name, const glm::ivec3& dims, field::SampleType type);

// The name of a file without its folder and the extensions of its format.
[[nodiscard]] std::string stem_of(const std::filesystem::path& path);

}  // namespace isoextract::volume_io
