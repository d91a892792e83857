// What the readers of the single formats give to volume_reader.cpp. Private to io.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "files/file_bytes.hpp"
#include "volumes/detail/sample_source.hpp"
#include "volumes/volume_reader.hpp"

namespace isoextract::volumes {

// Where a file says its samples are. A frame that cannot be used is only an error if the options do not replace it.
struct Frame {
  field::Affine index_to_world;
  std::string problem;  // "axis 2 has no direction"; empty if all is well
};

// A dense volume whose header was read and checked; its samples were not.
struct DenseFile {
  std::string format;  // "NRRD"
  std::string world_space;
  field::SampleType type = field::SampleType::u8;
  glm::ivec3 dims{0};
  std::endian endian = std::endian::native;
  bool x_slowest = false;  // stored with the last axis fastest
  field::ValueScale scale;
  Frame frame;
  std::vector<SamplePiece> pieces;
  bool size_is_exact = false;  // bytes after the samples are an error, not a note
  std::string size_hint;       // what helps where the size is wrong
  std::vector<std::string> notes;
};

[[nodiscard]] Result<DenseFile> open_nrrd(const files::InputFile& file);
[[nodiscard]] Result<DenseFile> open_nifti(const files::InputFile& file);
[[nodiscard]] Result<DenseFile> open_npy(const files::InputFile& file);
[[nodiscard]] Result<DenseFile> open_raw(const files::InputFile& file, const RawLayout& layout);

[[nodiscard]] Result<std::vector<GridInfo>> list_vdb_grids(const files::InputFile& file, const Limits& limits);
[[nodiscard]] Result<field::ScalarField> read_vdb(const files::InputFile& file, const ReadOptions& options);

// Whether the first bytes of a file (inflated where it is gzip) are of a format. kDetectionBytes are enough.
inline constexpr std::size_t kDetectionBytes = 1024;
[[nodiscard]] bool looks_like_vdb(std::span<const std::byte> content);
[[nodiscard]] bool looks_like_nrrd(std::span<const std::byte> content);
[[nodiscard]] bool looks_like_nifti(std::span<const std::byte> content);
[[nodiscard]] bool looks_like_npy(std::span<const std::byte> content);
[[nodiscard]] bool starts_with(std::span<const std::byte> content, std::string_view magic);

// What `file` should start with and does not. For the readers, where an extension or option chose the format.
[[nodiscard]] tl::unexpected<Error> fail_magic(const files::InputFile& file, std::string_view format,
                                               std::string_view expected);

// Sizes from a header as dims. Fails where one is 0 or too large for an index, or where all together are more than
// 2^62 bytes.
[[nodiscard]] Result<glm::ivec3> checked_dims(const std::string& file, const std::array<std::uint64_t, 3>& sizes,
                                              field::SampleType type);

[[nodiscard]] std::uint64_t sample_bytes(const glm::ivec3& dims, field::SampleType type);

// "100x100x100 f32 samples"
[[nodiscard]] std::string describe_samples(const glm::ivec3& dims, field::SampleType type);

// Sets the field's index_to_world from its file and --spacing and --origin. Messages name field.source.
[[nodiscard]] Result<void> set_frame(field::ScalarField& field, const Frame& frame, const ReadOptions& options);

}  // namespace isoextract::volumes
