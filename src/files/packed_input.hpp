// Packed bytes of a file on their way into zlib: read a block at a time, from places in the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

struct z_stream_s;

namespace isoextract::files {

// Outlived by the file it reads.
class PackedInput {
 public:
  // The packed bytes lie in [begin, end) of the file. `window_bits` says what is around them, as zlib's inflateInit2()
  // has it.
  PackedInput(const InputFile& file, std::uint64_t begin, std::uint64_t end, int window_bits);

  [[nodiscard]] const InputFile& file() const { return *file_; }
  // For inflate(): its next_in and avail_in are the bytes that were read and not inflated.
  [[nodiscard]] z_stream_s& stream() { return *stream_; }
  [[nodiscard]] const z_stream_s& stream() const { return *stream_; }
  // Whether all packed bytes were read.
  [[nodiscard]] bool is_read() const { return next_ >= end_; }

  // Reads the next block; bytes that are not inflated come before it.
  [[nodiscard]] Result<void> refill();

 private:
  struct End {
    void operator()(z_stream_s* stream) const;
  };

  const InputFile* file_;
  std::uint64_t next_;
  std::uint64_t end_;
  std::unique_ptr<z_stream_s, End> stream_;
  std::vector<std::byte> packed_;
};

}  // namespace isoextract::files
