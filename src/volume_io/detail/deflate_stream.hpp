// Decompresses a Deflate member (RFC 1951) of a ZIP file sequentially.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/error.hpp"
#include "files/compressed_input.hpp"

namespace isoextract::volume_io {

// Sizes and checksum of a compressed member from the ZIP directory.
struct DeflatedMember {
  std::uint64_t packed = 0;    // compressed bytes in the file
  std::uint64_t inflated = 0;  // bytes of the content
  std::uint32_t crc = 0;       // CRC-32 of the content
};

// The file must outlive the stream.
class DeflateStream {
 public:
  // `offset` is the position of the compressed bytes, which must lie within the file.
  DeflateStream(const files::InputFile& file, std::uint64_t offset, const DeflatedMember& member);

  // Returns the number of bytes written to `out` (at most 2 GiB); less than out.size() only at the end of the content.
  // Fails with ErrorCode::input for damaged data, or if length or checksum differ from the member.
  [[nodiscard]] Result<std::size_t> inflate(std::span<std::byte> out);

 private:
  [[nodiscard]] Result<void> check_end() const;

  files::CompressedInput input_;
  DeflatedMember member_;
  std::uint64_t inflated_ = 0;
  std::uint32_t crc_;
  bool ended_ = false;
};

}  // namespace isoextract::volume_io
