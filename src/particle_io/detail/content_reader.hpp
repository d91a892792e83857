// The content of a file from front to back in blocks, inflated where the file is gzip: bytes, or lines of text.
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

// Where a line begins.
struct LinePlace {
  std::uint64_t position = 0;
  std::uint64_t number = 0;  // of the line before it
  char line_end = 0;         // how lines end; 0 until that is known
};

// Throws DamagedParticles and Refused. One reader of a file at a time. Reports bytes of the file as "reading".
class ContentReader {
 public:
  explicit ContentReader(const files::InputFile& file);

  // For what is kept of the content; the message where there is no room names the file.
  [[nodiscard]] Reservation reserve(std::uint64_t bytes, std::string_view what) const;

  // Where in the content the next byte is.
  [[nodiscard]] std::uint64_t position() const { return start_ + begin_; }
  // No more bytes than that follow, however much a header tells of.
  [[nodiscard]] std::uint64_t most_left() const { return most_ - std::min(most_, position()); }

  // The next bytes, without going past them: at least `wanted` of them where there are so many, and all that are at
  // hand. At most kMostPeeked. Valid until the next call.
  static constexpr std::size_t kMostPeeked = std::size_t{1} << 20;
  [[nodiscard]] std::span<const std::byte> peek(std::size_t wanted);
  // Past bytes that were seen.
  void advance(std::size_t bytes) { begin_ += bytes; }
  // The next bytes, no more and no fewer; `what` says what they are, for where the content ends before.
  [[nodiscard]] std::span<const std::byte> take(std::size_t bytes, std::string_view what);
  void skip(std::uint64_t bytes, std::string_view what);

  // The next line, without its end: a line feed, with a carriage return before it or not; a carriage return alone where
  // the first block has no line feed. Nothing at the end. Valid until the next call.
  [[nodiscard]] std::optional<std::string_view> next_line();
  // The same, but it stays the next one.
  [[nodiscard]] std::optional<std::string_view> peek_line();
  // Of the line that was read last, counted from 1.
  [[nodiscard]] std::uint64_t line_number() const { return line_number_; }
  // Where the next line begins, and going to where it began in an earlier reader of the same file; not in gzip files.
  // `expected` bytes, if that many are known, are read at first, so that a short frame does not cost a whole block.
  [[nodiscard]] LinePlace line_place() const { return {position(), line_number_, line_end_}; }
  [[nodiscard]] bool can_go_to_lines() const { return !gzip_; }
  void go_to(const LinePlace& place, std::uint64_t expected);

  // Throws: "line 3: expected WHAT, found 'FOUND'".
  [[noreturn]] void expected(std::string_view what, std::string_view found) const;

 private:
  [[nodiscard]] std::size_t refill();

  const files::InputFile& file_;
  std::optional<files::GzipStream> gzip_;
  std::uint64_t most_ = 0;   // bytes of the content
  std::uint64_t taken_ = 0;  // of the file, where it is not gzip
  std::uint64_t start_ = 0;  // where in the content the buffer begins
  std::size_t begin_ = 0;    // of what is left in it
  std::size_t end_ = 0;
  std::uint64_t piece_ = kMostPeeked * 2;  // bytes that are read at a time, where there is room
  bool at_end_ = false;
  char line_end_ = 0;  // 0 until it is known
  std::uint64_t line_number_ = 0;
  Reservation memory_;
  Buffer<std::byte> buffer_;
};

}  // namespace isoextract::particle_io
