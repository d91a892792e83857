#include "particle_io/detail/content_reader.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/checked.hpp"
#include "base/printable.hpp"
#include "files/parked_streams.hpp"
#include "particle_io/detail/particle_source.hpp"

namespace isoextract::particle_io {
namespace {

constexpr std::size_t kMostBuffered = 2 * ContentReader::kMaxPeekedBytes;
constexpr std::uint64_t kLeastPiece = std::uint64_t{1} << 16;
// Bytes to inflate at a time once the line end is known: a parked stream keeps its unread bytes.
constexpr std::size_t kInflatedPiece = std::size_t{1} << 16;
constexpr std::size_t kMostParked = 4 * kInflatedPiece;

}  // namespace

ContentReader::ContentReader(const files::InputFile& file) : file_(file), most_(file.size()) {
  std::array<std::byte, 2> start{};
  if (file.size() >= start.size()) must(file.read_at(0, start));
  std::uint64_t buffered = kMostBuffered;
  if (files::is_gzip(start)) {
    is_compressed_ = true;
    most_ = checked_product(file.size(), files::kMaxDeflateRatio).value_or(~std::uint64_t{0});
  } else {
    buffered = std::min<std::uint64_t>(buffered, file.size());
  }
  memory_ = must(file.context().reserve(buffered, file.name() + ": a block of the file"));
  buffer_ = Buffer<std::byte>(static_cast<std::size_t>(buffered));
  file.context().progress().begin("reading", is_compressed_ ? 0 : file.size());
}

Reservation ContentReader::reserve(std::uint64_t bytes, std::string_view what) const {
  return must(file_.context().reserve(bytes, fmt::format("{}: {}", file_.name(), what)));
}

// Moves the unread bytes to the front of the buffer and appends bytes to them. Returns the number of new bytes; 0 at
// the end of the content.
std::size_t ContentReader::refill() {
  if (at_end_) return 0;
  must(file_.context().check());
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    start_ += begin_;
    end_ -= begin_;
    begin_ = 0;
  }
  const auto room = buffer_.span().subspan(end_);
  std::size_t got = 0;
  if (is_compressed_) {
    if (!gzip_) gzip_ = must(files::GzipStream::open(file_, 0));
    const auto piece = line_end_ == 0 ? room : room.first(std::min(room.size(), kInflatedPiece));
    got = must(gzip_->inflate_to_cut(piece));
    if (got == 0 && gzip_->is_cut_off()) {
      throw TruncatedFrame("the gzip data is damaged or cut off: unexpected end of file", "the gzip data ends");
    }
    at_end_ = got < piece.size() && !gzip_->is_cut_off();
  } else {
    got = static_cast<std::size_t>(std::min({std::uint64_t{room.size()}, file_.size() - taken_, piece_}));
    piece_ = std::min<std::uint64_t>(2 * std::max(piece_, kLeastPiece), kMostBuffered);
    must(file_.read_at(taken_, room.first(got)));
    taken_ += got;
    at_end_ = taken_ == file_.size();
    file_.context().progress().advance(got);
  }
  end_ += got;
  return got;
}

std::span<const std::byte> ContentReader::peek(std::size_t wanted) {
  while (end_ - begin_ < wanted && refill() > 0) {
  }
  return std::as_const(buffer_).span().subspan(begin_, end_ - begin_);
}

std::span<const std::byte> ContentReader::take(std::size_t bytes, std::string_view what) {
  const auto found = peek(bytes);
  if (found.size() < bytes) {
    throw InvalidParticleFile(
        fmt::format("expected {} bytes ({}) from byte {} on, found {}", bytes, what, position(), found.size()));
  }
  advance(bytes);
  return found.first(bytes);
}

void ContentReader::skip(std::uint64_t bytes, std::string_view what) {
  if (bytes > max_remaining_bytes()) {
    throw InvalidParticleFile(
        fmt::format("expected {} bytes ({}) from byte {} on, found the end of the file", bytes, what, position()));
  }
  while (bytes > 0) {
    const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(bytes, kMaxPeekedBytes));
    static_cast<void>(take(part, what));
    bytes -= part;
  }
}

void ContentReader::inflate_to(std::uint64_t place) {
  const auto streams = files::kept_streams(file_.context());
  const auto version = must(files::version_of(file_));
  if (auto parked = streams ? streams->find(file_, version, place) : std::nullopt) {
    gzip_ = std::move(parked->stream);
    std::ranges::copy(parked->unread, buffer_.data());
    start_ = parked->position;
    begin_ = 0;
    end_ = parked->unread.size();
  }
  while (position() < place) {
    if (begin_ == end_ && refill() == 0) break;
    begin_ += static_cast<std::size_t>(std::min<std::uint64_t>(end_ - begin_, place - position()));
  }
}

void ContentReader::park() {
  const auto streams = files::kept_streams(file_.context());
  const std::size_t unread = end_ - begin_;
  if (!streams || !gzip_ || unread > kMostParked || (at_end_ && unread == 0)) return;
  const auto version = must(files::version_of(file_));
  if (!version.is_reliable()) return;
  const auto bytes = std::as_const(buffer_).span().subspan(begin_, unread);
  streams->park(version, {position(), {bytes.begin(), bytes.end()}, std::move(*gzip_)});
}

void ContentReader::go_to(const LineStart& place, std::uint64_t expected) {
  if (is_compressed_) {
    line_end_ = place.line_end;
    inflate_to(place.position);
    line_number_ = place.number;
    return;
  }
  start_ = place.position;
  taken_ = place.position;
  begin_ = 0;
  end_ = 0;
  at_end_ = taken_ >= file_.size();
  line_number_ = place.number;
  line_end_ = place.line_end;
  // The line end is detected in a whole block.
  piece_ = place.line_end == 0 ? kMostBuffered
                               : std::clamp<std::uint64_t>(expected == 0 ? kLeastPiece : expected, 1, kMostBuffered);
}

std::optional<std::string_view> ContentReader::next_line() {
  std::size_t looked = 0;
  while (true) {
    const auto rest = std::as_const(buffer_).span().subspan(begin_, end_ - begin_);
    if (line_end_ == 0 && !rest.empty()) {
      line_end_ = std::memchr(rest.data(), '\n', rest.size()) == nullptr &&
                          std::memchr(rest.data(), '\r', rest.size()) != nullptr
                      ? '\r'
                      : '\n';
    }
    const void* found =
        rest.size() > looked ? std::memchr(rest.data() + looked, line_end_, rest.size() - looked) : nullptr;
    const auto* text = reinterpret_cast<const char*>(rest.data());
    if (found != nullptr) {
      const auto length = static_cast<std::size_t>(static_cast<const char*>(found) - text);
      ++line_number_;
      line_has_end_ = true;
      advance(length + 1);
      return std::string_view(text, length > 0 && text[length - 1] == '\r' ? length - 1 : length);
    }
    looked = rest.size();
    if (looked > kMaxPeekedBytes) {
      ++line_number_;
      expected(fmt::format("the end of a line within {} bytes", kMaxPeekedBytes), {text, 40});
    }
    if (refill() > 0) continue;
    if (rest.empty()) return std::nullopt;
    ++line_number_;
    line_has_end_ = false;
    advance(looked);
    return std::string_view(text, text[looked - 1] == '\r' ? looked - 1 : looked);
  }
}

std::optional<std::string_view> ContentReader::peek_line() {
  const std::uint64_t before = position();
  const auto line = next_line();
  if (!line) return std::nullopt;
  begin_ -= static_cast<std::size_t>(position() - before);
  --line_number_;
  return line;
}

void ContentReader::expected(std::string_view what, std::string_view found) const {
  const std::string shown = found.empty() ? "nothing" : fmt::format("'{}'", printable(found, 40));
  if (!line_has_end_) {
    throw TruncatedFrame(fmt::format("line {}: expected {}, found {}", line_number_, what, shown),
                         "the file ends within a line");
  }
  throw InvalidParticleFile(fmt::format("line {}: expected {}, found {}", line_number_, what, shown));
}

void check_count(const ContentReader& content, std::uint64_t count, std::uint64_t least_bytes) {
  const auto least = checked_product(count, least_bytes);
  if (least && *least <= content.max_remaining_bytes()) return;
  throw TruncatedFrame(
      fmt::format("{} particles or entries need at least {} bytes; the file has at most {} after byte {}", count,
                  least ? std::to_string(*least) : "2^64", content.max_remaining_bytes(), content.position()),
      fmt::format("its {} particles need more bytes than follow", count));
}

}  // namespace isoextract::particle_io
