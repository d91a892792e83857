#include "volume_io/vdb/vdb_cursor.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace isoextract::volume_io {

void VdbCursor::seek(std::uint64_t position) {
  if (position > end_) {
    throw InvalidVdb(fmt::format("a file offset points to byte {}, beyond the end of the {} at byte {}", position,
                                 range_name(), end_));
  }
  if (position < begin_ || position > begin_ + length_) {
    window_.reset();
    length_ = 0;
    begin_ = position;
  }
  at_ = position - begin_;
}

bool VdbCursor::is_prepared(std::uint64_t count) const { return std::min(count, size() - position()) <= length_ - at_; }

void VdbCursor::prepare(std::uint64_t count) {
  if (is_prepared(count)) return;
  if (auto wanted = file_.context().check(); !wanted) throw VdbReadError(wanted.error());
  // Twice the requested size, so that no more bytes are copied between windows than are read.
  constexpr std::uint64_t kWindow = std::uint64_t{256} << 10;
  const std::size_t kept = length_ - at_;
  const std::size_t length = std::min(size() - position(), std::max(kWindow, 2 * count));
  auto window = std::make_shared_for_overwrite<std::byte[]>(length);
  std::copy_n(window_.get() + at_, kept, window.get());
  const std::span<std::byte> fresh(window.get() + kept, length - kept);
  if (auto read = file_.read_at(position() + kept, fresh); !read) throw VdbReadError(read.error());
  file_.context().progress().advance(fresh.size());
  begin_ += at_;
  at_ = 0;
  length_ = length;
  window_ = std::move(window);
}

std::span<const std::byte> VdbCursor::take(std::uint64_t count) {
  const std::uint64_t left = end_ - position();
  if (count > left) {
    throw InvalidVdb(
        fmt::format("expected {} bytes from byte {} on, the {} has {}", count, position(), range_name(), left));
  }
  prepare(count);
  const std::span<const std::byte> taken(window_.get() + at_, count);
  at_ += count;
  return taken;
}

std::string VdbCursor::read_text(std::uint64_t length) {
  const auto bytes = take(length);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string VdbCursor::read_name() {
  constexpr std::uint32_t kMaxLength = 64 << 10;
  const auto length = read_value<std::uint32_t>();
  if (length > end_ - position()) {
    throw InvalidVdb(fmt::format("expected a name of {} bytes, found {} bytes left in the {}", length,
                                 end_ - position(), range_name()));
  }
  if (length > kMaxLength) {
    throw UnsupportedVdb(fmt::format("a name is {} characters long, the limit is {}", length, kMaxLength));
  }
  return read_text(length);
}

}  // namespace isoextract::volume_io
