// Feeds compressed bytes of a file to zlib, one block (256 KiB) at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

struct z_stream_s;

namespace isoextract::files {

// The file must outlive this object.
class CompressedInput {
 public:
  // The compressed bytes are [begin, end) of the file. `window_bits` selects the container format as in zlib's
  // inflateInit2(). Throws std::bad_alloc.
  CompressedInput(const InputFile& file, std::uint64_t begin, std::uint64_t end, int window_bits);

  // Returns a copy that goes on from the same byte. It reads from `file`, which must be the same version of the file.
  // Throws std::bad_alloc.
  [[nodiscard]] CompressedInput copy_for(const InputFile& file) const;

  [[nodiscard]] const InputFile& file() const { return *file_; }
  // Returns the stream for inflate(): next_in and avail_in are the bytes read and not yet decompressed.
  [[nodiscard]] z_stream_s& stream() { return *stream_; }
  [[nodiscard]] const z_stream_s& stream() const { return *stream_; }
  // Returns whether all compressed bytes have been read from the file.
  [[nodiscard]] bool is_read() const { return next_ >= end_; }

  // Reads the next block; keeps unconsumed bytes in front of it. Reads nothing if is_read(). Fails as
  // InputFile::read_at() does.
  [[nodiscard]] Result<void> refill();

 private:
  CompressedInput() = default;

  struct End {
    void operator()(z_stream_s* stream) const;
  };

  const InputFile* file_ = nullptr;
  std::uint64_t next_ = 0;
  std::uint64_t end_ = 0;
  std::unique_ptr<z_stream_s, End> stream_;
  std::vector<std::byte> packed_;
};

}  // namespace isoextract::files
