// The content of a gzip file from front to back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

struct z_stream_s;

namespace isoextract::files {

// Deflate cannot shrink anything below 1/1032 of its size.
inline constexpr std::uint64_t kMostInflated = 1032;

// Outlived by the file it reads. Members may follow each other; what follows the last one is not looked at.
class GzipStream {
 public:
  // `offset` is where in the file the packed data begins.
  [[nodiscard]] static Result<GzipStream> open(const InputFile& file, std::uint64_t offset);

  // How many bytes came; fewer than asked for only at the end of intact data. At most 2 GiB at a time.
  [[nodiscard]] Result<std::size_t> inflate(std::span<std::byte> out);

 private:
  struct End {
    void operator()(z_stream_s* stream) const;
  };
  using Handle = std::unique_ptr<z_stream_s, End>;
  GzipStream(const InputFile& file, std::uint64_t offset, Handle stream);

  // Reads on where nothing is left to inflate.
  [[nodiscard]] Result<void> refill();
  // Behind a member: whether another one follows.
  [[nodiscard]] Result<bool> begin_next_member();
  [[nodiscard]] tl::unexpected<Error> damaged(const char* why) const;

  const InputFile* file_;
  std::uint64_t next_;  // byte of the file that is read next
  Handle stream_;
  bool ended_ = false;  // the last member has
  std::vector<std::byte> packed_;
};

}  // namespace isoextract::files
