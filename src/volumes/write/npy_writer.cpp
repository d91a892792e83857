#include <bit>

#include <fmt/format.h>

#include "field/sample_type.hpp"
#include "volumes/write/dense_writers.hpp"

namespace isoextract::volumes {

std::string npy_header(const field::DenseSamples& samples) {
  const std::string_view type = field::sample_type_name(samples.type);  // "u16"; NumPy counts bytes
  const std::size_t size = field::sample_size(samples.type);
  const char order = size == 1 ? '|' : std::endian::native == std::endian::little ? '<' : '>';
  const glm::ivec3& dims = samples.dims;
  const std::string layers = dims.z == 1 ? "" : fmt::format("{}, ", dims.z);
  std::string text = fmt::format("{{'descr': '{}{}{}', 'fortran_order': False, 'shape': ({}{}, {}), }}", order,
                                 type.front(), size, layers, dims.y, dims.x);
  constexpr std::size_t kStart = 10;  // magic number, version, length
  constexpr std::size_t kAligned = 64;
  text.resize((kStart + text.size() + 1 + kAligned - 1) / kAligned * kAligned - kStart - 1, ' ');
  text += '\n';
  std::string header = "\x93NUMPY";
  header += {'\1', '\0', static_cast<char>(text.size() & 255U), static_cast<char>(text.size() >> 8U)};
  return header + text;
}

}  // namespace isoextract::volumes
