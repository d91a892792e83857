#include "volume_io/npy_text.hpp"

#include <fmt/format.h>

namespace isoextract::volume_io {

std::string npy_header(std::string_view type, std::string_view shape) {
  std::string text = fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': {}, }}", type, shape);
  constexpr std::size_t kStart = 10;  // signature, version, length
  constexpr std::size_t kAligned = 64;
  text.resize((kStart + text.size() + 1 + kAligned - 1) / kAligned * kAligned - kStart - 1, ' ');
  text += '\n';
  std::string header = "\x93NUMPY";
  header += {'\1', '\0', static_cast<char>(text.size() & 255U), static_cast<char>(text.size() >> 8U)};
  return header + text;
}

}  // namespace isoextract::volume_io
