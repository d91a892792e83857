#include "simulate/detail/nozzle.hpp"

#include <cmath>

#include "base/hash.hpp"

namespace isoextract::simulate {

namespace {

// Returns the number of lattice rows on either side of the axis.
int rows_of(const NozzleOptions& options) { return static_cast<int>(options.radius / options.spacing); }

}  // namespace

std::uint64_t Nozzle::bytes(const NozzleOptions& options) {
  const std::uint64_t side = 2 * static_cast<std::uint64_t>(rows_of(options)) + 1;
  return side * side * sizeof(glm::dvec2);
}

Nozzle::Nozzle(const NozzleOptions& options) : options_(options) {
  lattice_.reserve(bytes(options) / sizeof(glm::dvec2));
  const int rows = rows_of(options);
  for (int z = -rows; z <= rows; ++z) {
    for (int y = -rows; y <= rows; ++y) {
      const glm::dvec2 place = options.spacing * glm::dvec2(y, z);
      if (glm::dot(place, place) <= options.radius * options.radius) lattice_.push_back(place);
    }
  }
}

glm::dvec3 Nozzle::jitter() const {
  glm::dvec3 off;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t random =
        splitmix64(splitmix64(options_.seed) + 3 * emitted_ + static_cast<std::uint64_t>(axis));
    off[axis] = std::ldexp(static_cast<double>(random >> 11U), -52) - 1;  // -1 to 1
  }
  return kJitter * options_.spacing * off;
}

}  // namespace isoextract::simulate
