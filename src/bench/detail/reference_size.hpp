// The exact area and volume of the surface of an analytic field in the cube [-1, 1]^3, computed without a mesh.
#pragma once

#include "base/progress.hpp"
#include "field/analytic_field.hpp"

namespace isoextract::bench {

struct ReferenceSize {
  field::SurfaceSize size;
  bool closed_form = false;
  // 0 in closed form; else the absolute change from the last doubling of the columns, which exceeds the true error.
  field::SurfaceSize uncertainty;
};

// Returns the closed form if the field has one. Otherwise integrates along columns; `iso` must be finite.
//
// Columns are lines parallel to each axis a through the centers of the squares of a grid. Roots of value = iso are
// bracketed on each line and solved for. A surface integral is the sum over all axes and columns of w_a / |n_a| times
// the integrand and the area of a square, for any weights w that sum to 1. Here w_a = n_a^8 / (n_x^8 + n_y^8 + n_z^8),
// with the unit normal n. This weight divided by |n_a| is smooth even where the surface folds over a column, so the
// midpoint rule converges with an order above 4. The number of columns along an axis starts at 96 and doubles until the
// area changes by at most 5e-4 of itself, but not beyond 384.
//
// Fields with AnalyticField::inside_length_along_z use the closed form of each column along z, with 1,023 and then
// 2,047 columns along an axis. The integral of the inside lengths is the volume; graphs over z get their area from
// these columns, too. For other fields, the volume follows from the divergence theorem: a third of the integral of
// p . n over the surface and over the part of the cube's faces above iso.
[[nodiscard]] ReferenceSize find_reference_size(const field::AnalyticField& field, double iso,
                                                Progress* progress = nullptr);

}  // namespace isoextract::bench
