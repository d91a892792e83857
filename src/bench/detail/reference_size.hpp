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
// Columns are lines parallel to each axis a through the centers of a square grid. Roots of value = iso are bracketed on
// each line and solved for. A surface integral is the sum over all axes and columns of w_a / |n_a| times the integrand
// and the area of a square, for any weights w that sum to 1. Here w_a = n_a^8 / (n_x^8 + n_y^8 + n_z^8), with the unit
// normal n. This is smooth even where the surface folds over a column, so the midpoint rule converges with an order
// above 4. Columns are doubled from 96 along an axis until the area changes by at most 5e-4 of itself, and at most to
// 384.
//
// The volume is the integral of AnalyticField::inside_length_along_z, or follows from the divergence theorem: a third
// of the integral of p . n over the surface and over the part of the cube's faces above iso. The area of a graph over z
// is integrated as such. These closed-form columns are 1,023, then 2,047 along an axis.
[[nodiscard]] ReferenceSize find_reference_size(const field::AnalyticField& field, double iso,
                                                Progress* progress = nullptr);

}  // namespace isoextract::bench
