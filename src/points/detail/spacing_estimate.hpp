// Estimates the spacing of particles: the side of the cube that a particle has for itself where particles fill a
// volume.
#pragma once

#include <optional>

#include "base/context.hpp"
#include "base/error.hpp"
#include "points/detail/nearby_positions.hpp"

namespace isoextract::points {

// Returns the spacing in world units; nothing unless two particles, or images of one, differ in position.
//
// The volume of a particle comes from its 48 nearest neighbors. Let l_i be the eigenvalues of the covariance of the
// particle and its neighbors. Then these m particles of spacing s fill a box with sides w_i = sqrt(12 l_i + s^2), so
// that
//   m s^3 = c w_1 w_2 w_3.
// This is exact with c = 1 for m = a x b x d points of a cubic lattice, so also for sheets and threads. For these, the
// distance to the k-th neighbor tells no volume. Neighbors cut out by a ball fill more than a box of the same
// covariance: c = 1 + 0.02 w_2 / w_1 + 0.05 w_3 / w_1. These numbers are fitted to lattices, jittered lattices and
// random points: their results lie within 4 % of the truth. c = 1 if a particle has fewer than 48 neighbors.
//
// Measures up to 2^12 particles, evenly spaced by index. Particles near a surface have more space than inner ones; so
// only particles near the mean of their neighbors count, unless they are fewer than 1 in 20. The result is the median
// of the counted spacings up to 1.25 times their 10 % quantile. So it belongs to the densest region that holds a tenth
// of the particles, and ignores spray and stray particles. Coincident particles count once. In a periodic box, images
// are neighbors, too.
//
// Fails as Context::check() does. The result is the same for any number of threads.
[[nodiscard]] Result<std::optional<double>> estimate_spacing(const NearbyPositions& positions, const Context& context);

}  // namespace isoextract::points
