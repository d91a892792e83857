#include <bit>

#include <fmt/format.h>

#include "field/sample_type.hpp"
#include "volume_io/npy_text.hpp"
#include "volume_io/write/dense_writers.hpp"

namespace isoextract::volume_io {

std::string npy_header(const field::DenseSamples& samples) {
  const std::string_view type = field::sample_type_name(samples.type);  // "u16"; NumPy's size is in bytes
  const std::size_t size = field::sample_size(samples.type);
  const char order = size == 1 ? '|' : std::endian::native == std::endian::little ? '<' : '>';
  const glm::ivec3& dims = samples.dims;
  const std::string layers = dims.z == 1 ? "" : fmt::format("{}, ", dims.z);
  return npy_header(fmt::format("'{}{}{}'", order, type.front(), size),
                    fmt::format("({}{}, {})", layers, dims.y, dims.x));
}

}  // namespace isoextract::volume_io
