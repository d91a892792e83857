// A kernel of its own shape for each particle.
//
// J. Yu, G. Turk: Reconstructing surfaces of particle-based fluids using anisotropic kernels. ACM Transactions on
// Graphics 32(1), 2013, section 4 (numbers of equations as there):
//
//   w_ij = 1 - (|x_i - x_j| / r)^3 nearer than r, else 0             (11)
//   x_i^w = sum w_ij x_j / sum w_ij                                  (10)
//   centre of kernel i = (1 - lambda) x_i + lambda x_i^w             (6)
//   C_i = sum w_ij (x_j - x_i^w)(x_j - x_i^w)^T / sum w_ij           (9)
//   C_i = R diag(s_1, s_2, s_3) R^T, s_1 >= s_2 >= s_3               (12), (13)
//   S = k_s diag(s_1, max(s_2, s_1 / k_r), max(s_3, s_1 / k_r)) with more than N_eps neighbours, else k_n I    (15)
//   G_i = 1/h R S^-1 R^T,  W(d, G) = det(G) P(|G d|)                 (16), (8)
//
// P is the cubic spline and h its support; r = 2h, as the paper has it, so that enough neighbours are met (in a liquid
// some 250 with a support of four particle radii, and around 50 in a sheet of one layer). k_s stands in the paper as a
// length^-2 that fits its own units: it is to make |k_s C| about 1 for a particle within the liquid. There
// C = 0.15 r^2 I (from (9), with a constant density), so here k_s counts in units of 1 / (0.15 r^2), and 1 does that in
// every unit.
//
// Beyond the paper: where k_s s_1 is below k_n, the particle counts as one with few neighbours. A crowd narrower than a
// single particle's kernel, down to many at one place, would have no shape otherwise.
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
  CellGrid grid;  // of the centres; no two share a spot
  std::shared_ptr<ReservedBuffer<float>> weights;
  std::shared_ptr<ReservedBuffer<Ellipsoid>> shapes;
  std::shared_ptr<ReservedBuffer<std::uint32_t>> counts;
  double reach = 0;

  [[nodiscard]] KernelSet set() const {
    return {&grid, weights->values.data(), shapes->values.data(), counts->values.data(), reach};
  }
};

// One kernel for each spot of `grid`, whose density `densities` are. `support` is in grid coordinates.
[[nodiscard]] Result<AnisotropicKernels> make_anisotropic_kernels(const CellGrid& grid, double support,
                                                                  const float* densities,
                                                                  const AnisotropyOptions& options,
                                                                  const Context& context, const std::string& label);

}  // namespace isoextract::points
