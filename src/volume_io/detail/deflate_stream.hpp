// A member of a ZIP file that is packed by Deflate (RFC 1951), from front to back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/error.hpp"
#include "files/packed_input.hpp"

namespace isoextract::volume_io {

// What the directory of a ZIP file says of a packed member.
struct DeflatedMember {
  std::uint64_t packed = 0;    // bytes in the file
  std::uint64_t inflated = 0;  // bytes of the content
  std::uint32_t crc = 0;       // CRC-32 of the content
};

// Outlived by the file it reads.
class DeflateStream {
 public:
  // `offset` is where in the file the packed bytes begin; they lie within it.
  DeflateStream(const files::InputFile& file, std::uint64_t offset, const DeflatedMember& member);

  // How many bytes came; fewer than asked for only at the end of intact data, whose length and checksum are what the
  // member says. At most 2 GiB at a time.
  [[nodiscard]] Result<std::size_t> inflate(std::span<std::byte> out);

 private:
  [[nodiscard]] Result<void> check_end() const;

  files::PackedInput input_;
  DeflatedMember member_;
  std::uint64_t inflated_ = 0;
  std::uint32_t crc_;
  bool ended_ = false;
};

}  // namespace isoextract::volume_io
