#include "zarr_codecs.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "zarr_decompress.hpp"

namespace isoextract_zarr {
namespace {

constexpr std::uint64_t kChecksumBytes = 4;

void swap_bytes(std::span<std::byte> bytes, std::uint64_t number) {
  for (std::size_t at = 0; at + number <= bytes.size(); at += number) {
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                 bytes.begin() + static_cast<std::ptrdiff_t>(at + number));
  }
}

// Inverts numcodecs' shuffle, which stores the first bytes of all elements, then the second bytes, and so on; bytes
// after the last whole element are stored unchanged.
void unshuffle(std::span<const std::byte> from, std::span<std::byte> to, std::uint64_t element) {
  const std::size_t count = from.size() / element;
  for (std::size_t part = 0; part < element; ++part) {
    for (std::size_t i = 0; i < count; ++i) to[i * element + part] = from[part * count + i];
  }
  std::ranges::copy(from.subspan(count * element), to.begin() + static_cast<std::ptrdiff_t>(count * element));
}

template <class T>
void sum_differences_of(std::span<std::byte> bytes) {
  T sum = 0;
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    T difference{};
    std::memcpy(&difference, bytes.data() + at, sizeof difference);
    sum = static_cast<T>(sum + difference);
    std::memcpy(bytes.data() + at, &sum, sizeof sum);
  }
}

std::span<std::byte> without_checksum(std::span<std::byte> bytes) {
  if (bytes.size() < kChecksumBytes) {
    throw ReadError(fmt::format("expected a checksum of {} bytes, found {}", kChecksumBytes, bytes.size()));
  }
  const std::span content = bytes.first(bytes.size() - kChecksumBytes);
  const auto stored = little_endian<std::uint32_t>(bytes, content.size());
  const std::uint32_t computed = crc32c(content);
  if (stored != computed) throw ReadError(fmt::format("expected the CRC-32C {:08x}, found {:08x}", stored, computed));
  return content;
}

}  // namespace

std::optional<Codec::Kind> find_codec(const std::string& name) {
  using enum Codec::Kind;
  constexpr std::array<std::pair<std::string_view, Codec::Kind>, 9> kNames{{{"zlib", deflate},
                                                                            {"gzip", deflate},
                                                                            {"zstd", zstd},
                                                                            {"blosc", blosc},
                                                                            {"lz4", lz4},
                                                                            {"bz2", bz2},
                                                                            {"lzma", lzma},
                                                                            {"shuffle", shuffle},
                                                                            {"crc32c", Codec::Kind::crc32c}}};
  std::string_view wanted(name);
  constexpr std::string_view kPackage = "numcodecs.";
  if (wanted.starts_with(kPackage)) wanted.remove_prefix(kPackage.size());
  const auto* const found = std::ranges::find(kNames, wanted, [](const auto& entry) { return entry.first; });
  if (found == kNames.end()) return std::nullopt;
  return found->second;
}

bool is_compressor(Codec::Kind kind) { return kind != Codec::Kind::shuffle && kind != Codec::Kind::crc32c; }

std::span<std::byte> Workspace::buffer(std::size_t number, std::uint64_t bytes) {
  Bytes& found = buffers_[number];
  if (found.size() < bytes) {
    memory_.take(bytes - found.size());
    found = Bytes();
    found.resize(bytes);
  }
  return std::span(found).first(bytes);
}

std::uint64_t most_encoded(std::uint64_t bytes) {
  constexpr std::uint64_t kSlack = std::uint64_t{1} << 20;
  return 2 * bytes + kSlack;
}

std::optional<std::uint64_t> encoded_size(const Pipeline& pipeline, std::uint64_t bytes) {
  for (const Codec& codec : pipeline.codecs) {
    if (is_compressor(codec.kind)) return std::nullopt;
    if (codec.kind == Codec::Kind::crc32c) bytes += kChecksumBytes;
  }
  return bytes;
}

std::span<std::byte> decode(const Pipeline& pipeline, std::span<std::byte> encoded, std::uint64_t bytes,
                            std::uint64_t number, Workspace& space) {
  std::span<std::byte> content = encoded;
  std::size_t free_buffer = 1;
  for (std::size_t i = pipeline.codecs.size(); i-- > 0;) {
    const Codec& codec = pipeline.codecs[i];
    if (codec.kind == Codec::Kind::crc32c) {
      content = without_checksum(content);
      continue;
    }
    std::uint64_t size = content.size();
    if (is_compressor(codec.kind)) {
      // The codecs before a compressor keep the size or add a checksum.
      size = bytes;
      for (const Codec& earlier : std::span(pipeline.codecs).first(i)) {
        if (earlier.kind == Codec::Kind::crc32c) size += kChecksumBytes;
      }
      check_plausible(codec.kind, content, size);
    }
    const std::span to = space.buffer(free_buffer, size);
    if (codec.kind == Codec::Kind::shuffle) {
      unshuffle(content, to, codec.element);
    } else {
      decompress(codec.kind, content, to);
    }
    content = to;
    free_buffer = 1 - free_buffer;
  }
  if (content.size() != bytes) throw ReadError(fmt::format("expected {} bytes, found {}", bytes, content.size()));
  if (number > 1 && pipeline.is_big_endian != (std::endian::native == std::endian::big)) swap_bytes(content, number);
  return content;
}

void sum_differences(std::span<std::byte> bytes, std::uint64_t element) {
  switch (element) {
    case 1: return sum_differences_of<std::uint8_t>(bytes);
    case 2: return sum_differences_of<std::uint16_t>(bytes);
    case 4: return sum_differences_of<std::uint32_t>(bytes);
    default: return sum_differences_of<std::uint64_t>(bytes);
  }
}

std::uint32_t crc32c(std::span<const std::byte> bytes) {
  static const auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) {
      std::uint32_t rest = i;
      for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1) ^ ((rest & 1) != 0 ? 0x82f63b78U : 0U);
      table[i] = rest;
    }
    return table;
  }();
  std::uint32_t sum = 0xffffffff;
  for (const std::byte byte : bytes) sum = kTable[(sum ^ std::to_integer<std::uint32_t>(byte)) & 0xff] ^ (sum >> 8);
  return ~sum;
}

}  // namespace isoextract_zarr
