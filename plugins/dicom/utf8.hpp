// Decodes UTF-8 (RFC 3629).
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace isoextract_dicom {

struct Utf8Character {
  char32_t code = 0;
  std::size_t bytes = 0;  // 0: there is no character
};

// Returns the character at the byte `at`; no character at the end, and for bytes that are not UTF-8.
[[nodiscard]] inline Utf8Character utf8_at(std::string_view text, std::size_t at) {
  if (at >= text.size()) return {};
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(at);
  if (first < 0x80) return {first, 1};
  const std::size_t bytes = first < 0xC0 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF8 ? 4 : 0;
  if (bytes == 0 || bytes > text.size() - at) return {};
  char32_t code = first & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(at + i) & 0xC0U) != 0x80U) return {};
    code = code << 6U | (byte(at + i) & 0x3FU);
  }
  constexpr std::array<char32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};  // of characters with so many bytes
  const bool is_surrogate = code >= 0xD800 && code < 0xE000;
  if (code < kLeast[bytes] || is_surrogate || code > 0x10FFFF) return {};
  return {code, bytes};
}

}  // namespace isoextract_dicom
