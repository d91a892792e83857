#include "volume_io/detail/deflate_stream.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <zlib.h>

namespace isoextract::volume_io {
namespace {

constexpr std::size_t kPackedBlock = std::size_t{1} << 18;

}  // namespace

void DeflateStream::End::operator()(z_stream_s* stream) const {
  ::inflateEnd(stream);
  delete stream;
}

DeflateStream::DeflateStream(const files::InputFile& file, std::uint64_t offset, const DeflatedMember& member,
                             Handle stream)
    : file_(&file),
      next_(offset),
      left_(member.packed),
      member_(member),
      stream_(std::move(stream)),
      crc_(static_cast<std::uint32_t>(::crc32(0, nullptr, 0))) {}

Result<DeflateStream> DeflateStream::open(const files::InputFile& file, std::uint64_t offset,
                                          const DeflatedMember& member) {
  auto stream = std::make_unique<z_stream_s>();
  // No header of zlib's or gzip's is before a member.
  if (::inflateInit2(stream.get(), -MAX_WBITS) != Z_OK) throw std::bad_alloc();
  return DeflateStream(file, offset, member, Handle(stream.release()));
}

Result<void> DeflateStream::refill() {
  packed_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kPackedBlock, left_)));
  TRY(file_->read_at(next_, packed_));
  next_ += packed_.size();
  left_ -= packed_.size();
  stream_->next_in = reinterpret_cast<Bytef*>(packed_.data());
  stream_->avail_in = static_cast<uInt>(packed_.size());
  return {};
}

Result<void> DeflateStream::check_end() const {
  if (stream_->avail_in > 0 || left_ > 0) {
    return fail(ErrorCode::input, file_->name() + ": a packed member ends before its packed bytes do");
  }
  if (inflated_ != member_.inflated) {
    return fail(ErrorCode::input, fmt::format("{}: a packed member holds {} bytes, its directory says {}",
                                              file_->name(), inflated_, member_.inflated));
  }
  if (crc_ != member_.crc) {
    return fail(ErrorCode::input,
                fmt::format("{}: a packed member is damaged: its checksum is {:08x}, its directory says {:08x}",
                            file_->name(), crc_, member_.crc));
  }
  return {};
}

Result<std::size_t> DeflateStream::inflate(std::span<std::byte> out) {
  stream_->next_out = reinterpret_cast<Bytef*>(out.data());
  stream_->avail_out = static_cast<uInt>(out.size());
  while (stream_->avail_out > 0 && !ended_) {
    if (stream_->avail_in == 0 && left_ > 0) {
      TRY(refill());
    }
    const int code = ::inflate(stream_.get(), Z_NO_FLUSH);
    if (code == Z_MEM_ERROR) throw std::bad_alloc();
    ended_ = code == Z_STREAM_END;
    if (!ended_ && (code != Z_OK || (stream_->avail_in == 0 && left_ == 0 && stream_->avail_out > 0))) {
      return fail(ErrorCode::input, fmt::format("{}: a packed member is damaged or cut off: {}", file_->name(),
                                                stream_->msg != nullptr ? stream_->msg : "its packed bytes end"));
    }
  }
  const std::size_t got = out.size() - stream_->avail_out;
  crc_ = static_cast<std::uint32_t>(
      ::crc32_z(crc_, reinterpret_cast<const Bytef*>(out.data()), static_cast<z_size_t>(got)));
  inflated_ += got;
  if (ended_) {
    TRY(check_end());
  }
  return got;
}

}  // namespace isoextract::volume_io
