// Anisotropic kernels, one for each particle: wide along the surface and short across it.
//
// After J. Yu, G. Turk: Reconstructing surfaces of particle-based fluids using anisotropic kernels. ACM Transactions on
// Graphics 32(1), 2013, section 4 (with the paper's equation numbers). h is the support of the kernel:
//
//   w_ij = 1 - (|x_i - x_j| / r)^3 if nearer than r, else 0; r = h AnisotropyOptions::neighborhood, by default 2h (11)
//   x_i^w = sum w_ij x_j / sum w_ij                                  (10)
//   C_i = sum w_ij (x_j - x_i^w)(x_j - x_i^w)^T / sum w_ij           (9)
//   C_i = R diag(s_1, s_2, s_3) R^T, s_1 >= s_2 >= s_3               (12)
//   G_i = 1/h R A^-1 R^T,  W(d, G) = det(G) P(|G d|)                 (16), (8); P is the cubic spline
//
// Differs from the paper in the axes A and in the centers. The paper's centers draw every body in by about two particle
// radii. Its shortest axes, a quarter of the support, show as rings on a grid of the usual cell size. Here:
//
//   a_k = max(shortest, wide s_k / s_1)
//   wide = 1 + (widest - 1) clamp((1 - s_3 / s_1 - 0.1) / 0.6, 0, 1)
//
//   A = diag(mix(k_n, a_k, t))
//   t = clamp(min(c_i / N_eps, s_1 / (k_n 0.15 r^2)) - 1, 0, 1)
//
//   center of kernel i = x_i + lambda z_i n_i
//
// c_i = 2 sum over j != i of w_ij: the number of neighbors for constant density. 0.15 r^2 is s_1 for constant
// density on all sides. So an isolated particle, or a cluster narrower than a kernel, has a ball of radius k_n h. The
// axes change continuously with t: a jump would show as flicker. shortest is at least 3 samples: shorter axes fall
// between the samples.
//
// n_i is the direction of x_i^w - x_i, which is the inner normal near a surface. z_i is the mean depth along n_i of the
// neighbors in the same layer: neighbors nearer than 1.4 h and less than h / 2 above or below. So a kernel moves to the
// local surface of its layer, and convex and concave regions keep their volume; the paper's centers move to x_i^w. Deep
// inside (|x_i^w - x_i| below 0.2 h) centers stay; from 0.2 h to 0.4 h the move grows from 0 to its full length.
#pragma once

#include <memory>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "points/cell_grid.hpp"
#include "points/detail/kernel_bricks.hpp"
#include "points/particle_field.hpp"

namespace isoextract::points {

// Returns the largest distance from a sample to a particle that can affect the kernels at the sample. The distance and
// `support` are in samples.
[[nodiscard]] double anisotropic_reach(const AnisotropyOptions& options, double support);

struct AnisotropicKernels {
  CellGrid grid;  // of the kernel centers; every kernel has its own spot
  std::shared_ptr<ReservedBuffer<float>> weights;
  std::shared_ptr<ReservedBuffer<Ellipsoid>> shapes;
  std::shared_ptr<ReservedBuffer<std::uint32_t>> counts;
  double reach = 0;

  [[nodiscard]] KernelSet set() const {
    return {&grid, weights->values.data(), shapes->values.data(), counts->values.data(), reach};
  }
};

// Makes one kernel for each spot of `grid`. `densities` has one value per spot; `support` is in grid coordinates, whose
// unit is the spacing of the samples.
[[nodiscard]] Result<AnisotropicKernels> make_anisotropic_kernels(const CellGrid& grid, double support,
                                                                  const float* densities,
                                                                  const AnisotropyOptions& options,
                                                                  const Context& context, const std::string& label);

}  // namespace isoextract::points
