#include "base/printable.hpp"

#include <cstdint>
#include <optional>

#include <fmt/format.h>

namespace isoextract {
namespace {

struct Character {
  char32_t code;
  std::size_t bytes;
};

// Returns the first character of a non-empty text, or nothing if the text does not begin with valid UTF-8 (RFC 3629).
std::optional<Character> first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return Character{lead, 1};
  const std::size_t bytes = lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return std::nullopt;
  char32_t code = lead & (0x7fU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0U) != 0x80) return std::nullopt;
    code = code << 6U | (byte(i) & 0x3fU);
  }
  const bool longer_than_needed = (bytes == 3 && code < 0x800) || (bytes == 4 && code < 0x10000);
  const bool half_of_a_pair = code >= 0xd800 && code <= 0xdfff;
  if (longer_than_needed || half_of_a_pair || code > 0x10ffff) return std::nullopt;
  return Character{code, bytes};
}

// Returns whether a terminal acts on the character: a control character, a line or paragraph separator, or an
// embedding, override or isolate of the writing direction.
bool controls_terminal(char32_t code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || (code >= 0x2028 && code <= 0x202e) ||
         (code >= 0x2066 && code <= 0x2069);
}

std::string escaped(char32_t code) {
  switch (code) {
    case '\n': return "\\n";
    case '\r': return "\\r";
    case '\t': return "\\t";
    default: break;
  }
  const auto number = static_cast<std::uint32_t>(code);
  return code < 0x80 ? fmt::format("\\x{:02x}", number) : fmt::format("\\u{:04x}", number);
}

}  // namespace

std::string printable(std::string_view text, std::size_t max_bytes) {
  std::string shown;
  std::size_t at = 0;
  while (at < text.size()) {
    const auto character = first_character(text.substr(at));
    const std::size_t bytes = character ? character->bytes : 1;
    if (bytes > max_bytes - at) return shown + "...";
    if (!character) {
      shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[at]));
    } else if (controls_terminal(character->code)) {
      shown += escaped(character->code);
    } else {
      shown += text.substr(at, bytes);
    }
    at += bytes;
  }
  return shown;
}

std::string printable(std::span<const std::byte> bytes, std::size_t max_bytes) {
  return printable(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()), max_bytes);
}

}  // namespace isoextract
