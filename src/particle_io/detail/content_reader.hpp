// Reads the content of a file sequentially in blocks, decompressed if the file is gzip: as bytes or lines of text.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "base/buffer.hpp"
#include "base/memory_budget.hpp"
#include "files/file_bytes.hpp"
#include "files/gzip_stream.hpp"

namespace isoextract::particle_io {

// The start of a line.
struct LineStart {
  std::uint64_t position = 0;
  std::uint64_t number = 0;  // number of the line before
  char line_end = 0;         // the file's line end; 0 if unknown
};

// Throws InvalidParticleFile and Refused. Use one reader per file at a time. Reports bytes of the file as "reading".
class ContentReader {
 public:
  explicit ContentReader(const files::InputFile& file);

  // Reserves memory for data kept from the content; the message of a failure names the file.
  [[nodiscard]] Reservation reserve(std::uint64_t bytes, std::string_view what) const;

  // Returns the position of the next byte in the content.
  [[nodiscard]] std::uint64_t position() const { return start_ + begin_; }
  // Returns an upper bound for the remaining bytes, to check counts in headers.
  [[nodiscard]] std::uint64_t max_remaining_bytes() const { return most_ - std::min(most_, position()); }

  // Returns the next bytes without consuming them: at least `wanted` if the content has that many, and all that are
  // buffered. `wanted` is at most kMaxPeekedBytes. Valid until the next call.
  static constexpr std::size_t kMaxPeekedBytes = std::size_t{1} << 20;
  [[nodiscard]] std::span<const std::byte> peek(std::size_t wanted);
  // Consumes bytes that were peeked.
  void advance(std::size_t bytes) { begin_ += bytes; }
  // Consumes exactly `bytes` bytes; `what` describes them in the error if the content ends before.
  [[nodiscard]] std::span<const std::byte> take(std::size_t bytes, std::string_view what);
  void skip(std::uint64_t bytes, std::string_view what);

  // Consumes the next line and returns it without its end; nothing at the end. A line ends with LF or CR LF, or with CR
  // if the first block has no LF. Valid until the next call.
  [[nodiscard]] std::optional<std::string_view> next_line();
  // Returns the next line without consuming it.
  [[nodiscard]] std::optional<std::string_view> peek_line();
  // Returns the number of the last line read, from 1.
  [[nodiscard]] std::uint64_t line_number() const { return line_number_; }
  // next_line_start() returns the start of the next line. go_to() returns to a start found by an earlier reader of the
  // same file; not for gzip files. If `expected` is not 0, it reads that many bytes at first, so that a short frame
  // does not cost a whole block.
  [[nodiscard]] LineStart next_line_start() const { return {position(), line_number_, line_end_}; }
  [[nodiscard]] bool can_go_to_lines() const { return !gzip_; }
  void go_to(const LineStart& place, std::uint64_t expected);

  // Throws "line 3: expected WHAT, found 'FOUND'".
  [[noreturn]] void expected(std::string_view what, std::string_view found) const;

 private:
  [[nodiscard]] std::size_t refill();

  const files::InputFile& file_;
  std::optional<files::GzipStream> gzip_;
  std::uint64_t most_ = 0;   // upper bound for the bytes of the content
  std::uint64_t taken_ = 0;  // bytes read from the file, if not gzip
  std::uint64_t start_ = 0;  // position of the buffer in the content
  std::size_t begin_ = 0;    // unread bytes of the buffer: [begin_, end_)
  std::size_t end_ = 0;
  std::uint64_t piece_ = kMaxPeekedBytes * 2;  // bytes to read at a time, if there is room
  bool at_end_ = false;
  char line_end_ = 0;  // 0 if unknown
  std::uint64_t line_number_ = 0;
  Reservation memory_;
  Buffer<std::byte> buffer_;
};

}  // namespace isoextract::particle_io
