// Headers as in RFC 8878 (zstd) and "The .xz File Format" 1.2.0.
#include "decoder_window.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <string_view>

namespace isoextract_archive {
namespace {

// The bytes of a file in order; nothing beyond its end.
class Bytes {
 public:
  explicit Bytes(const std::string& path) : file_(path, std::ios::binary) {}

  std::optional<std::uint64_t> byte() { return number(1); }
  // Returns a little-endian number.
  std::optional<std::uint64_t> number(int bytes) {
    std::array<char, 8> read{};
    if (!file_.read(read.data(), bytes)) return std::nullopt;
    std::uint64_t value = 0;
    for (int i = bytes - 1; i >= 0; --i) {
      value = value << 8U | static_cast<unsigned char>(read[static_cast<std::size_t>(i)]);
    }
    return value;
  }
  // Returns a number of xz: 7 bits in each byte, and the highest bit where more bytes follow.
  std::optional<std::uint64_t> xz_number() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 63; shift += 7) {
      const auto part = byte();
      if (!part) return std::nullopt;
      value |= (*part & 0x7fU) << shift;
      if (*part < 0x80) return value;
    }
    return std::nullopt;
  }
  void skip(std::uint64_t bytes) { file_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur); }

 private:
  std::ifstream file_;
};

// Reads after the magic number of a frame.
std::optional<std::uint64_t> zstd_window(Bytes& bytes) {
  const auto descriptor = bytes.byte();
  if (!descriptor) return std::nullopt;
  const bool is_single_segment = (*descriptor & 0x20U) != 0;
  std::uint64_t window = ~std::uint64_t{0};
  if (!is_single_segment) {
    const auto coded = bytes.byte();
    if (!coded) return std::nullopt;
    const std::uint64_t base = std::uint64_t{1} << (10 + (*coded >> 3U));
    window = base + base / 8 * (*coded & 7U);
  }
  constexpr std::array<std::uint64_t, 4> kDictionaryBytes{0, 1, 2, 4};
  bytes.skip(kDictionaryBytes[*descriptor & 3U]);
  constexpr std::array kSizeBytes{0, 2, 4, 8};
  const std::size_t size_code = *descriptor >> 6U;
  const int size_bytes = size_code == 0 && is_single_segment ? 1 : kSizeBytes[size_code];
  if (size_bytes == 0) return window;
  const auto size = bytes.number(size_bytes);
  if (!size) return std::nullopt;
  return std::min(window, size_bytes == 2 ? *size + 256 : *size);
}

// Reads after the magic number of a stream.
std::optional<std::uint64_t> xz_window(Bytes& bytes) {
  constexpr std::uint64_t kFlagsAndCheck = 6;
  bytes.skip(kFlagsAndCheck);
  const auto header_size = bytes.byte();
  if (!header_size || *header_size == 0) return std::nullopt;  // 0: a stream without blocks
  const auto flags = bytes.byte();
  if (!flags) return std::nullopt;
  for (const unsigned size_flag : {0x40U, 0x80U}) {  // the block's packed and unpacked size
    if ((*flags & size_flag) != 0 && !bytes.xz_number()) return std::nullopt;
  }
  const std::uint64_t filters = (*flags & 3U) + 1;
  for (std::uint64_t i = 0; i < filters; ++i) {
    const auto id = bytes.xz_number();
    const auto property_bytes = bytes.xz_number();
    if (!id || !property_bytes) return std::nullopt;
    constexpr std::uint64_t kLzma2 = 0x21;
    if (*id != kLzma2 || *property_bytes != 1) {
      bytes.skip(*property_bytes);
      continue;
    }
    const auto coded = bytes.byte();
    if (!coded || *coded > 40) return std::nullopt;
    if (*coded == 40) return (std::uint64_t{1} << 32U) - 1;
    return (2 | (*coded & 1U)) << (*coded / 2 + 11);
  }
  return std::nullopt;
}

}  // namespace

std::uint64_t stated_window(const std::string& path) {
  Bytes bytes(path);
  auto magic = bytes.number(4);
  constexpr std::uint64_t kZstd = 0xfd2fb528;
  constexpr std::uint64_t kZstdSkippable = 0x184d2a5;  // without the lowest 4 bits
  constexpr int kMostSkipped = 16;
  for (int i = 0; i < kMostSkipped && magic && *magic >> 4U == kZstdSkippable; ++i) {
    const auto size = bytes.number(4);
    if (!size) return 0;
    bytes.skip(*size);
    magic = bytes.number(4);
  }
  if (magic == kZstd) return zstd_window(bytes).value_or(0);
  constexpr std::uint64_t kXzStart = 0x587a37fd;  // fd '7' 'z' 'X'
  constexpr std::uint64_t kXzEnd = 0x005a;        // 'Z' 00
  if (magic == kXzStart && bytes.number(2) == kXzEnd) return xz_window(bytes).value_or(0);
  return 0;
}

}  // namespace isoextract_archive
