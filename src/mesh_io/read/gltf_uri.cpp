// The URIs of glTF's buffers: names of files (RFC 3986) and data (RFC 2397).
#include <charconv>

#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {
namespace {

std::vector<std::byte> decode_base64(std::string_view text, MemoryUse& memory) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::byte> bytes;
  memory.make_room(bytes, text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int count = 0;
  while (text.ends_with('=')) text.remove_suffix(1);
  for (const char c : text) {
    const std::size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos)
      throw DamagedMesh("expected base64 data in a buffer's URI, found other characters");
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count & 0xFFU));
  }
  return bytes;
}

}  // namespace

std::string decode_percent(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned value = 0;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(uri.data() + i + 1, uri.data() + i + 3, value, 16).ptr == uri.data() + i + 3) {
      text += static_cast<char>(value);
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

std::vector<std::byte> decode_data_uri(std::string_view uri, MemoryUse& memory) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) throw DamagedMesh("expected a comma in a buffer's data URI, found none");
  const std::string_view data = uri.substr(comma + 1);
  if (uri.substr(0, comma).ends_with(";base64")) return decode_base64(data, memory);
  std::vector<std::byte> bytes;
  memory.make_room(bytes, 2 * data.size());
  const std::string text = decode_percent(data);
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

}  // namespace isoextract::mesh_io
