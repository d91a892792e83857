// Anisotropic kernels, one for each particle.
//
// J. Yu, G. Turk: Reconstructing surfaces of particle-based fluids using anisotropic kernels. ACM Transactions on
// Graphics 32(1), 2013, section 4 (with the paper's equation numbers):
//
//   w_ij = 1 - (|x_i - x_j| / r)^3 if nearer than r, else 0          (11)
//   x_i^w = sum w_ij x_j / sum w_ij                                  (10)
//   center of kernel i = (1 - lambda) x_i + lambda x_i^w             (6)
//   C_i = sum w_ij (x_j - x_i^w)(x_j - x_i^w)^T / sum w_ij           (9)
//   C_i = R diag(s_1, s_2, s_3) R^T, s_1 >= s_2 >= s_3               (12), (13)
//   S = k_s diag(s_1, max(s_2, s_1 / k_r), max(s_3, s_1 / k_r)) with more than N_eps neighbors, else k_n I     (15)
//   G_i = 1/h R S^-1 R^T,  W(d, G) = det(G) P(|G d|)                 (16), (8)
//
// P is the cubic spline and h its support. As in the paper r = 2h, so that a particle has enough neighbors: about 250
// in a liquid and 50 in a one-layer sheet, with a support of four particle radii.
//
// In the paper k_s is a length^-2 in its own units, chosen so that |k_s C| is about 1 within the liquid. There
// C = 0.15 r^2 I, from (9) with constant density. Here k_s is in units of 1 / (0.15 r^2), so 1 fits every unit.
//
// Differs from the paper: if k_s s_1 is below k_n, the particle counts as having few neighbors. Otherwise a cluster
// narrower than one particle's kernel, such as coincident particles, would have a degenerate shape.
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

// Makes one kernel for each spot of `grid`. `densities` has one value per spot; `support` is in grid coordinates.
[[nodiscard]] Result<AnisotropicKernels> make_anisotropic_kernels(const CellGrid& grid, double support,
                                                                  const float* densities,
                                                                  const AnisotropyOptions& options,
                                                                  const Context& context, const std::string& label);

}  // namespace isoextract::points
