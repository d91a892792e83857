// The true area and volume of the surface of an analytic field inside the cube [-1, 1]^3, found without any mesh.
#pragma once

#include "base/progress.hpp"
#include "field/analytic_field.hpp"

namespace isoextract::bench {

struct ReferenceSize {
  field::SurfaceSize size;
  bool closed_form = false;
  field::SurfaceSize
      uncertainty;  // 0 in closed form; else what the last doubling of the columns changed, which is more
};

// In closed form where the field has one. Else by columns: along lines parallel to each axis a, through the centres of
// a square grid, the roots of value = iso are bracketed and solved for. A surface integral is the sum over the axes of
// the columns' sums of w_a / |n_a| times the integrand, for any weights w that sum to 1. With w_a = n_a^8 / (n_x^8 +
// n_y^8 + n_z^8), n the unit normal, that is smooth also where the surface folds over a column, so the midpoint rule
// converges with an order above 4; the columns are doubled until that changes the area by less than 5e-4, at most to
// 384 along an axis. The volume is the integral of AnalyticField::length_along_z, or else follows from the divergence
// theorem: a third of the integral of p . n over the surface and over the part of the cube's faces that is above iso.
// Of a graph over z the area is integrated as such. `iso` must be finite.
[[nodiscard]] ReferenceSize find_reference_size(const field::AnalyticField& field, double iso,
                                                Progress* progress = nullptr);

}  // namespace isoextract::bench
