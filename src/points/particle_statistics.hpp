// Facts of a particle set that need no field: where it is, how densely its particles lie.
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
  field::Box box;                           // of the finite positions; zero where there are none
  std::uint64_t finite = 0;                 // particles
  std::uint64_t not_finite = 0;             // particles with a coordinate that is infinite or NaN
  std::optional<std::size_t> first_broken;  // the first of those
};

// The same for any number of threads.
[[nodiscard]] ParticleBounds measure_bounds(std::span<const glm::dvec3> positions);

// Distances from particles to the nearest one at another place, in world units.
struct NeighbourDistances {
  std::uint64_t asked = 0;  // how many particles these are of: all up to 2^16, of more so many, evenly spaced by index
  double min = 0;
  double median = 0;
  double max = 0;
};

struct ParticleStatistics {
  ParticleBounds bounds;
  std::optional<NeighbourDistances> neighbours;  // nothing where no two are at different places

  // Half the median distance: that of particles that lie on a lattice and touch.
  [[nodiscard]] std::optional<double> suggested_radius() const {
    if (!neighbours) return std::nullopt;
    return neighbours->median / 2;
  }
};

// Fails as Context::reserve() does, and where the context is cancelled. The same for any number of threads.
[[nodiscard]] Result<ParticleStatistics> measure_statistics(const ParticleSet& particles, const Context& context);

}  // namespace isoextract::points
