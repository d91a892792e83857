#include "volume_io/detail/deflate_stream.hpp"

#include <new>

#include <fmt/format.h>
#include <zlib.h>

namespace isoextract::volume_io {

// -MAX_WBITS: raw Deflate, without a zlib or gzip header.
DeflateStream::DeflateStream(const files::InputFile& file, std::uint64_t offset, const DeflatedMember& member)
    : input_(file, offset, offset + member.packed, -MAX_WBITS),
      member_(member),
      crc_(static_cast<std::uint32_t>(::crc32(0, nullptr, 0))) {}

Result<void> DeflateStream::check_end() const {
  if (input_.stream().avail_in > 0 || !input_.is_read()) {
    return fail(
        ErrorCode::input,
        input_.file().name() +
            ": the compressed data of an array ends before its compressed size, which the ZIP directory states");
  }
  if (inflated_ != member_.inflated) {
    return fail(ErrorCode::input, fmt::format("{}: an array decompresses to {} bytes; the ZIP directory states {}",
                                              input_.file().name(), inflated_, member_.inflated));
  }
  if (crc_ != member_.crc) {
    return fail(ErrorCode::input,
                fmt::format("{}: an array is damaged: its checksum is {:08x}; the ZIP directory states {:08x}",
                            input_.file().name(), crc_, member_.crc));
  }
  return {};
}

Result<std::size_t> DeflateStream::inflate(std::span<std::byte> out) {
  z_stream& stream = input_.stream();
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  while (stream.avail_out > 0 && !ended_) {
    if (stream.avail_in == 0 && !input_.is_read()) {
      TRY(input_.refill());
    }
    const int code = ::inflate(&stream, Z_NO_FLUSH);
    if (code == Z_MEM_ERROR) throw std::bad_alloc();
    ended_ = code == Z_STREAM_END;
    if (!ended_ && (code != Z_OK || (stream.avail_in == 0 && input_.is_read() && stream.avail_out > 0))) {
      return fail(ErrorCode::input, fmt::format("{}: an array is damaged or cut off: {}", input_.file().name(),
                                                stream.msg != nullptr ? stream.msg : "its compressed bytes end"));
    }
  }
  const std::size_t got = out.size() - stream.avail_out;
  crc_ = static_cast<std::uint32_t>(
      ::crc32_z(crc_, reinterpret_cast<const Bytef*>(out.data()), static_cast<z_size_t>(got)));
  inflated_ += got;
  if (ended_) {
    TRY(check_end());
  }
  return got;
}

}  // namespace isoextract::volume_io
