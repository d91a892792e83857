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

  // Consumes the next line and returns it without its line end; returns nothing at the end of the content. A line ends
  // with LF or CR LF, or with CR if the first block has no LF. Throws if it is longer than kMaxPeekedBytes. Valid until
  // the next call.
  [[nodiscard]] std::optional<std::string_view> next_line();
  // Returns the next line without consuming it.
  [[nodiscard]] std::optional<std::string_view> peek_line();
  // Returns whether the last line read has a line end; false for the last line of a file that was cut off within it.
  [[nodiscard]] bool line_has_end() const { return line_has_end_; }
  // Returns the number of the last line read, from 1.
  [[nodiscard]] std::uint64_t line_number() const { return line_number_; }
  // Returns the start of the next line.
  [[nodiscard]] LineStart next_line_start() const { return {position(), line_number_, line_end_}; }
  // Goes to a line start that an earlier reader of the same file found; call before reading anything. If `expected` is
  // not 0, first reads that many bytes, so that a short frame does not cost a whole block. Inflates a gzip file from
  // the nearest stream parked before `place`, else from its start.
  void go_to(const LineStart& place, std::uint64_t expected);
  [[nodiscard]] bool is_compressed() const { return is_compressed_; }
  // Parks the stream of a gzip file at the current position for later readers, if the context keeps streams
  // (files/parked_streams.hpp). Call last.
  void park();

  // Throws "line 3: expected WHAT, found 'FOUND'": TruncatedFrame if the line has no end, else InvalidParticleFile.
  [[noreturn]] void expected(std::string_view what, std::string_view found) const;

 private:
  [[nodiscard]] std::size_t refill();
  // Inflates the content up to a position after the current one, starting at a parked stream if there is one.
  void inflate_to(std::uint64_t place);

  const files::InputFile& file_;
  bool is_compressed_ = false;
  std::optional<files::GzipStream> gzip_;  // set once bytes are inflated
  std::uint64_t most_ = 0;                 // upper bound for the bytes of the content
  std::uint64_t taken_ = 0;                // bytes read from the file, if not gzip
  std::uint64_t start_ = 0;                // position of the buffer in the content
  std::size_t begin_ = 0;                  // unread bytes of the buffer: [begin_, end_)
  std::size_t end_ = 0;
  std::uint64_t piece_ = kMaxPeekedBytes * 2;  // bytes to read at a time, if there is room
  bool at_end_ = false;
  char line_end_ = 0;  // 0 if unknown
  bool line_has_end_ = true;
  std::uint64_t line_number_ = 0;
  Reservation memory_;
  Buffer<std::byte> buffer_;
};

// Throws TruncatedFrame if the rest of the content is too short for `count` particles of at least `least_bytes`.
void check_count(const ContentReader& content, std::uint64_t count, std::uint64_t least_bytes);

}  // namespace isoextract::particle_io
