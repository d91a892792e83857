#include "base/printable_json.hpp"

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "base/printable.hpp"

namespace isoextract {

std::string printable_json(std::string json) {
  // Returns the position of the next character that may have to be escaped: DEL, a C1 control (c2), a separator or a
  // change of direction (e2).
  const auto find_from = [&](std::size_t begin) {
    const auto may_need_escape = [](char c) { return c == '\x7f' || c == '\xc2' || c == '\xe2'; };
    return static_cast<std::size_t>(
        std::find_if(json.begin() + static_cast<std::ptrdiff_t>(begin), json.end(), may_need_escape) - json.begin());
  };
  std::size_t at = find_from(0);
  if (at == json.size()) return json;
  std::string shown;
  std::size_t copied = 0;
  while (at != json.size()) {
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
    at = find_from(at + 1);
  }
  return shown + json.substr(copied);
}

}  // namespace isoextract
