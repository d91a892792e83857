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
  std::optional<std::size_t> first_broken;  // index of the first particle with such a coordinate
};

// The result is the same for any number of threads.
[[nodiscard]] ParticleBounds measure_bounds(std::span<const glm::dvec3> positions);

// Distances from particles to their nearest neighbor at a different position, in world units. In a periodic box, images
// of particles count as neighbors, here and in suggest_radius().
struct NeighborDistances {
  // Number of measured particles: all or, of more than 2^16, 2^16 evenly spaced by index. Skips non-finite positions.
  std::uint64_t asked = 0;
  double min = 0;
  double median = 0;
  double max = 0;
};

struct ParticleStatistics {
  ParticleBounds bounds;
  std::optional<NeighborDistances> neighbors;  // empty unless two particles or images differ in position
  std::optional<double> suggested_radius;      // as suggest_radius() returns it
};

// Fails with ErrorCode::input for 2^32 particles or more, and as Context::reserve() and Context::check() do. The result
// is the same for any number of threads.
[[nodiscard]] Result<ParticleStatistics> measure_statistics(const ParticleSet& particles, const Context& context);

// Returns half the spacing of a cubic lattice as dense as the particles, in world units: the radius of touching
// particles. The density comes from the 48 nearest neighbors of at most 2^12 particles (detail/spacing_estimate.hpp).
// Returns nothing unless two particles, or images of one, differ in position. Fails as measure_statistics() does.
[[nodiscard]] Result<std::optional<double>> suggest_radius(const ParticleSet& particles, const Context& context);

}  // namespace isoextract::points
