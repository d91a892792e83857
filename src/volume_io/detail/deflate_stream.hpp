// A member of a ZIP file that is packed by Deflate (RFC 1951), from front to back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

struct z_stream_s;

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
  [[nodiscard]] static Result<DeflateStream> open(const files::InputFile& file, std::uint64_t offset,
                                                  const DeflatedMember& member);

  // How many bytes came; fewer than asked for only at the end of intact data, whose length and checksum are what the
  // member says. At most 2 GiB at a time.
  [[nodiscard]] Result<std::size_t> inflate(std::span<std::byte> out);

 private:
  struct End {
    void operator()(z_stream_s* stream) const;
  };
  using Handle = std::unique_ptr<z_stream_s, End>;
  DeflateStream(const files::InputFile& file, std::uint64_t offset, const DeflatedMember& member, Handle stream);

  [[nodiscard]] Result<void> refill();
  [[nodiscard]] Result<void> check_end() const;

  const files::InputFile* file_;
  std::uint64_t next_;  // in the file
  std::uint64_t left_;  // packed bytes that were not read yet
  DeflatedMember member_;
  Handle stream_;
  std::vector<std::byte> packed_;
  std::uint64_t inflated_ = 0;
  std::uint32_t crc_;
  bool ended_ = false;
};

}  // namespace isoextract::volume_io
