#include "zarr_decompress.hpp"

#include <blosc.h>
#include <bzlib.h>
#include <lz4.h>
#include <lzma.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace isoextract_zarr {
namespace {

constexpr std::size_t kLz4Header = 4;  // numcodecs writes the decompressed size before the block

[[noreturn]] void wrong_size(const char* codec, std::uint64_t expected, std::uint64_t found) {
  throw ReadError(fmt::format("expected {} decompressed bytes of {}, found {}", expected, codec, found));
}

[[noreturn]] void damaged(const char* codec, std::uint64_t expected) {
  throw ReadError(fmt::format("expected {} decompressed bytes of {}, found damaged ones", expected, codec));
}

// Returns how many of `left` bytes to pass in one call of a library with 32-bit sizes.
unsigned step_of(std::size_t left) { return static_cast<unsigned>(std::min<std::size_t>(left, 1U << 30)); }

// A gzip file may have several members.
void inflate_all(std::span<const std::byte> from, std::span<std::byte> to) {
  constexpr int kAnyHeader = 15 + 32;
  z_stream stream{};
  if (::inflateInit2(&stream, kAnyHeader) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, ::inflateEnd);
  std::size_t read = 0;
  std::size_t written = 0;
  std::byte beyond{};  // receives a byte that does not fit into `to`
  while (true) {
    const bool is_full = written == to.size();
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(from.data() + read));
    const unsigned given = step_of(from.size() - read);
    stream.avail_in = given;
    stream.next_out = reinterpret_cast<Bytef*>(is_full ? &beyond : to.data() + written);
    const unsigned room = is_full ? 1 : step_of(to.size() - written);
    stream.avail_out = room;
    const int status = ::inflate(&stream, Z_NO_FLUSH);
    const unsigned made = room - stream.avail_out;
    read += given - stream.avail_in;
    if (is_full && made > 0) wrong_size("deflate", to.size(), to.size() + 1);
    if (!is_full) written += made;
    if (status == Z_STREAM_END) {
      if (read == from.size()) break;
      if (::inflateReset(&stream) != Z_OK) damaged("deflate", to.size());
    } else if (status != Z_OK || (made == 0 && given == stream.avail_in)) {
      damaged("deflate", to.size());
    }
  }
  if (written != to.size()) wrong_size("deflate", to.size(), written);
}

void decompress_zstd(std::span<const std::byte> from, std::span<std::byte> to) {
  const std::size_t got = ::ZSTD_decompress(to.data(), to.size(), from.data(), from.size());
  if (::ZSTD_isError(got) != 0) damaged("zstd", to.size());
  if (got != to.size()) wrong_size("zstd", to.size(), got);
}

void decompress_blosc(std::span<const std::byte> from, std::span<std::byte> to) {
  // blosc_decompress_ctx trusts the lengths in the header.
  std::size_t size = 0;
  if (from.size() < BLOSC_MIN_HEADER_LENGTH || ::blosc_cbuffer_validate(from.data(), from.size(), &size) != 0)
    damaged("blosc", to.size());
  if (size != to.size()) wrong_size("blosc", to.size(), size);
  if (::blosc_decompress_ctx(from.data(), to.data(), to.size(), 1) != static_cast<int>(to.size()))
    damaged("blosc", to.size());
}

void decompress_lz4(std::span<const std::byte> from, std::span<std::byte> to) {
  constexpr auto kMost = static_cast<std::size_t>(LZ4_MAX_INPUT_SIZE);
  if (from.size() < kLz4Header || from.size() > kMost || to.size() > kMost) damaged("lz4", to.size());
  const std::span block = from.subspan(kLz4Header);
  const int got = ::LZ4_decompress_safe(reinterpret_cast<const char*>(block.data()), reinterpret_cast<char*>(to.data()),
                                        static_cast<int>(block.size()), static_cast<int>(to.size()));
  if (got < 0) damaged("lz4", to.size());
  if (static_cast<std::size_t>(got) != to.size()) wrong_size("lz4", to.size(), static_cast<std::uint64_t>(got));
}

void decompress_bz2(std::span<const std::byte> from, std::span<std::byte> to) {
  constexpr std::size_t kMost = std::numeric_limits<unsigned>::max();
  if (from.size() > kMost || to.size() > kMost) throw ReadError("bz2 chunks of 4 GiB or more are not supported");
  auto size = static_cast<unsigned>(to.size());
  const int status = ::BZ2_bzBuffToBuffDecompress(reinterpret_cast<char*>(to.data()), &size,
                                                  reinterpret_cast<char*>(const_cast<std::byte*>(from.data())),
                                                  static_cast<unsigned>(from.size()), 0, 0);
  if (status != BZ_OK) damaged("bz2", to.size());
  if (size != to.size()) wrong_size("bz2", to.size(), size);
}

void decompress_lzma(std::span<const std::byte> from, std::span<std::byte> to) {
  constexpr std::uint64_t kDecoderMemory = std::uint64_t{80} << 20;  // preset 9 has a dictionary of 64 MiB
  lzma_stream stream = LZMA_STREAM_INIT;
  if (::lzma_auto_decoder(&stream, kDecoderMemory, 0) != LZMA_OK) throw std::bad_alloc();
  const std::unique_ptr<lzma_stream, void (*)(lzma_stream*)> guard(&stream, ::lzma_end);
  stream.next_in = reinterpret_cast<const std::uint8_t*>(from.data());
  stream.avail_in = from.size();
  stream.next_out = reinterpret_cast<std::uint8_t*>(to.data());
  stream.avail_out = to.size();
  lzma_ret status = LZMA_OK;
  while (status == LZMA_OK) status = ::lzma_code(&stream, LZMA_FINISH);
  if (status == LZMA_MEMLIMIT_ERROR) throw ReadError("its lzma dictionary needs more than 80 MiB");
  if (status != LZMA_STREAM_END) damaged("lzma", to.size());
  if (stream.avail_out != 0) wrong_size("lzma", to.size(), to.size() - stream.avail_out);
}

}  // namespace

void check_plausible(Codec::Kind kind, std::span<const std::byte> from, std::uint64_t bytes) {
  constexpr std::uint64_t kDeflateRatio = 1032;
  constexpr std::uint64_t kLz4Ratio = 255;
  constexpr std::uint64_t kShort = 1024;  // headers
  switch (kind) {
    case Codec::Kind::deflate:
      if (bytes / kDeflateRatio > from.size()) wrong_size("deflate", bytes, from.size() * kDeflateRatio);
      return;
    case Codec::Kind::zstd: {
      const unsigned long long size = ::ZSTD_getFrameContentSize(from.data(), from.size());
      if (size == ZSTD_CONTENTSIZE_ERROR) damaged("zstd", bytes);
      // Several frames may follow one another.
      if (size != ZSTD_CONTENTSIZE_UNKNOWN && size > bytes) wrong_size("zstd", bytes, size);
      // A block of 4 bytes (header and a byte to repeat) decodes to at most 128 KiB.
      if (bytes >> 17 > from.size()) damaged("zstd", bytes);
      return;
    }
    case Codec::Kind::blosc: {
      std::size_t size = 0;
      if (from.size() < BLOSC_MIN_HEADER_LENGTH || ::blosc_cbuffer_validate(from.data(), from.size(), &size) != 0)
        damaged("blosc", bytes);
      if (size != bytes) wrong_size("blosc", bytes, size);
      return;
    }
    case Codec::Kind::lz4: {
      if (from.size() < kLz4Header) damaged("lz4", bytes);
      const auto size = little_endian<std::uint32_t>(from, 0);
      if (size != bytes) wrong_size("lz4", bytes, size);
      if (bytes / kLz4Ratio > from.size() + kShort) damaged("lz4", bytes);
      return;
    }
    case Codec::Kind::bz2:
    case Codec::Kind::lzma:
    case Codec::Kind::shuffle:
    case Codec::Kind::crc32c: return;
  }
}

void decompress(Codec::Kind kind, std::span<const std::byte> from, std::span<std::byte> to) {
  switch (kind) {
    case Codec::Kind::deflate: return inflate_all(from, to);
    case Codec::Kind::zstd: return decompress_zstd(from, to);
    case Codec::Kind::blosc: return decompress_blosc(from, to);
    case Codec::Kind::lz4: return decompress_lz4(from, to);
    case Codec::Kind::bz2: return decompress_bz2(from, to);
    case Codec::Kind::lzma: return decompress_lzma(from, to);
    case Codec::Kind::shuffle:
    case Codec::Kind::crc32c: return;
  }
}

}  // namespace isoextract_zarr
