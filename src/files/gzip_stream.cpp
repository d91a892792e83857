#include "files/gzip_stream.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <zlib.h>

namespace isoextract::files {
namespace {

constexpr std::size_t kPackedBlock = std::size_t{1} << 18;

}  // namespace

void GzipStream::End::operator()(z_stream_s* stream) const {
  ::inflateEnd(stream);
  delete stream;
}

GzipStream::GzipStream(const InputFile& file, std::uint64_t offset, Handle stream)
    : file_(&file), next_(offset), stream_(std::move(stream)) {}

Result<GzipStream> GzipStream::open(const InputFile& file, std::uint64_t offset) {
  auto stream = std::make_unique<z_stream_s>();
  constexpr int kGzipOnly = 16 + MAX_WBITS;
  if (::inflateInit2(stream.get(), kGzipOnly) != Z_OK) throw std::bad_alloc();
  GzipStream made(file, offset, Handle(stream.release()));
  const auto begins = TRY(made.begin_next_member());
  if (!begins) return fail(ErrorCode::input, file.name() + ": expected gzip data, found other bytes");
  return made;
}

Result<void> GzipStream::refill() {
  // What is left of the block moves to its front: a member's first bytes may lie on both sides of its end.
  const std::size_t left = stream_->avail_in;
  if (left > 0) std::copy(packed_.end() - static_cast<std::ptrdiff_t>(left), packed_.end(), packed_.begin());
  const std::uint64_t more = std::min<std::uint64_t>(kPackedBlock, file_->size() - std::min(next_, file_->size()));
  packed_.resize(left + static_cast<std::size_t>(more));
  TRY(file_->read_at(next_, std::span(packed_).subspan(left)));
  next_ += more;
  stream_->next_in = reinterpret_cast<Bytef*>(packed_.data());
  stream_->avail_in = static_cast<uInt>(packed_.size());
  return {};
}

Result<bool> GzipStream::begin_next_member() {
  if (stream_->avail_in < 2) {
    TRY(refill());
  }
  const bool begins = stream_->avail_in >= 2 && stream_->next_in[0] == 0x1f && stream_->next_in[1] == 0x8b;
  if (begins && ::inflateReset(stream_.get()) != Z_OK) throw std::bad_alloc();
  return begins;
}

tl::unexpected<Error> GzipStream::damaged(const char* why) const {
  return fail(ErrorCode::input, fmt::format("{}: the gzip data is damaged or cut off: {}", file_->name(),
                                            why != nullptr ? why : "compressed data error"));
}

Result<std::size_t> GzipStream::inflate(std::span<std::byte> out) {
  stream_->next_out = reinterpret_cast<Bytef*>(out.data());
  stream_->avail_out = static_cast<uInt>(out.size());
  while (stream_->avail_out > 0 && !ended_) {
    if (stream_->avail_in == 0) {
      TRY(refill());
      if (stream_->avail_in == 0) return damaged("unexpected end of file");
    }
    const int code = ::inflate(stream_.get(), Z_NO_FLUSH);
    if (code == Z_MEM_ERROR) throw std::bad_alloc();
    if (code == Z_STREAM_END) {
      const auto goes_on = TRY(begin_next_member());
      ended_ = !goes_on;
    } else if (code == Z_NEED_DICT) {
      return damaged("unexpected dictionary");
    } else if (code != Z_OK && code != Z_BUF_ERROR) {
      return damaged(stream_->msg);
    }
  }
  return out.size() - stream_->avail_out;
}

}  // namespace isoextract::files
