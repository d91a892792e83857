// Weighted neighbor counts of particles, which tell droplets from sheets and bulk.
//
// F. Loeschner, T. Boettcher, S. R. Jeske, J. Bender: Weighted Laplacian smoothing for surface reconstruction of
// particle-based fluids. VMV 2023.
#pragma once

#include <algorithm>
#include <cstddef>

#include "base/context.hpp"
#include "base/error.hpp"
#include "points/particle_set.hpp"

namespace isoextract::points {

// Appends an attribute with the sum of 1 - (d / support)^2 over the other particles at distances d below the support of
// a kernel, 2 * smoothing_length * radius, and returns its index. In a periodic box, particles count across its faces.
// Particles at non-finite positions have the count 0. `radius` is in world units, `smoothing_length` in radii. The
// result is bit-identical for any number of threads.
//
// Fails with ErrorCode::input if the particles are too far apart for the support, with ErrorCode::out_of_memory, and
// with ErrorCode::cancelled.
[[nodiscard]] Result<std::size_t> add_neighbor_counts(ParticleSet& particles, double radius, double smoothing_length,
                                                      const Context& context);

// Returns the smoothing weight of a vertex with this count, 0 to 1: a quintic smooth step up to 13, about the count
// inside a lattice of touching particles with the default smoothing length. A flat surface of the lattice has weight
// 0.8.
[[nodiscard]] constexpr double smoothing_weight(double count) {
  const double x = std::clamp(count / 13, 0.0, 1.0);
  return x * x * x * (x * (x * 6 - 15) + 10);
}

}  // namespace isoextract::points
