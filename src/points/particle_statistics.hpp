// Statistics of a particle set that need no field: its bounds and particle distances.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/affine.hpp"
#include "points/particle_set.hpp"

namespace isoextract::points {

struct ParticleBounds {
  field::Box box;                           // of the finite positions; zero if there are none
  std::uint64_t finite = 0;                 // particles
  std::uint64_t not_finite = 0;             // particles with an infinite or NaN coordinate
  std::optional<std::size_t> first_broken;  // index of the first of them
};

// The result is the same for any number of threads.
[[nodiscard]] ParticleBounds measure_bounds(std::span<const glm::dvec3> positions);

// Distances from particles to their nearest neighbor at a different position, in world units.
struct NeighborDistances {
  // Number of particles measured: of all up to 2^16, else of 2^16 evenly spaced by index, those at finite positions.
  std::uint64_t asked = 0;
  double min = 0;
  double median = 0;
  double max = 0;
};

struct ParticleStatistics {
  ParticleBounds bounds;
  std::optional<NeighborDistances> neighbors;  // empty unless two particles differ in position

  // Returns half the median distance: the radius of touching particles on a lattice.
  [[nodiscard]] std::optional<double> suggested_radius() const {
    if (!neighbors) return std::nullopt;
    return neighbors->median / 2;
  }
};

// Fails with ErrorCode::input for 2^32 particles or more, and as Context::reserve() and Context::check() do. The result
// is the same for any number of threads.
[[nodiscard]] Result<ParticleStatistics> measure_statistics(const ParticleSet& particles, const Context& context);

}  // namespace isoextract::points
