#include "files/gzip_stream.hpp"

#include <new>

#include <fmt/format.h>
#include <zlib.h>

namespace isoextract::files {
namespace {

constexpr const char* kCutOff = "unexpected end of file";

}  // namespace

Result<GzipStream> GzipStream::open(const InputFile& file, std::uint64_t offset) {
  constexpr int kGzipOnly = 16 + MAX_WBITS;
  GzipStream made(CompressedInput(file, offset, file.size(), kGzipOnly));
  const auto begins = TRY(made.begin_next_member());
  if (!begins) return fail(ErrorCode::input, file.name() + ": expected gzip data, found other bytes");
  return made;
}

Result<bool> GzipStream::begin_next_member() {
  z_stream& stream = input_.stream();
  if (stream.avail_in < 2) {
    TRY(input_.refill());
  }
  const bool begins = stream.avail_in >= 2 && stream.next_in[0] == 0x1f && stream.next_in[1] == 0x8b;
  if (begins && ::inflateReset(&stream) != Z_OK) throw std::bad_alloc();
  return begins;
}

tl::unexpected<Error> GzipStream::damaged(const char* why) const {
  return fail(ErrorCode::input, fmt::format("{}: the gzip data is damaged or cut off: {}", input_.file().name(),
                                            why != nullptr ? why : "compressed data error"));
}

GzipStream GzipStream::copy_for(const InputFile& file) const {
  GzipStream copy(input_.copy_for(file));
  copy.ended_ = ended_;
  copy.is_cut_off_ = is_cut_off_;
  return copy;
}

Result<std::size_t> GzipStream::inflate(std::span<std::byte> out) {
  const auto bytes = TRY(inflate_to_cut(out));
  if (is_cut_off_) return damaged(kCutOff);
  return bytes;
}

Result<std::size_t> GzipStream::inflate_to_cut(std::span<std::byte> out) {
  z_stream& stream = input_.stream();
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  while (stream.avail_out > 0 && !ended_) {
    if (stream.avail_in == 0) {
      TRY(input_.refill());
      is_cut_off_ = stream.avail_in == 0;
      if (is_cut_off_) break;
    }
    const int code = ::inflate(&stream, Z_NO_FLUSH);
    if (code == Z_MEM_ERROR) throw std::bad_alloc();
    if (code == Z_STREAM_END) {
      const auto goes_on = TRY(begin_next_member());
      ended_ = !goes_on;
    } else if (code == Z_NEED_DICT) {
      return damaged("unexpected dictionary");
    } else if (code != Z_OK && code != Z_BUF_ERROR) {
      return damaged(stream.msg);
    }
  }
  return out.size() - stream.avail_out;
}

}  // namespace isoextract::files
