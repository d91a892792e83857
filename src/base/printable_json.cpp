#include "base/printable_json.hpp"

#include <string_view>

#include "base/printable.hpp"

namespace isoextract {

std::string printable_json(std::string json) {
  // First bytes of the characters to escape: DEL, C1 controls (c2), separators and direction changes (e2).
  constexpr std::string_view kFirstBytes = "\x7f\xc2\xe2";
  std::size_t at = json.find_first_of(kFirstBytes);
  if (at == std::string::npos) return json;
  std::string shown;
  std::size_t copied = 0;
  while (at != std::string::npos) {
    const auto lead = static_cast<unsigned char>(json[at]);
    const std::size_t bytes = lead < 0x80 ? 1 : lead < 0xe0 ? 2 : 3;
    const std::string_view character = std::string_view(json).substr(at, bytes);
    std::string escaped = printable(character);
    // JSON has no \x escapes. Bytes that are not UTF-8 stay as they are: they are an error of the document's author.
    if (escaped == "\\x7f") escaped = "\\u007f";
    if (escaped.starts_with("\\u")) {
      shown += std::string_view(json).substr(copied, at - copied);
      shown += escaped;
      copied = at + bytes;
    }
    at = json.find_first_of(kFirstBytes, at + 1);
  }
  return shown + json.substr(copied);
}

}  // namespace isoextract
