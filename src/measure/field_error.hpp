// How far a mesh is from the isosurface of the data it came from.
//
// At a point p with residual r = f(p) - iso the first-order distance is |r| / |grad f|, with the gradient taken in the
// mesh's coordinates: a covector, mapped by the inverse transpose of the transform. That number misleads where the
// gradient changes within it, and most where the gradient is small. So it is only the first guess of a search for the
// crossing itself, along the gradient's line towards the surface, no further than `reach`, and where that line leaves
// dense data, along the border from there: beyond it there is no surface. Where that finds nothing, or only something
// twice as far, the search goes also towards those corners of the point's cell that are on the other side. What is
// reported is the length of the step to the nearest crossing found, which the true distance cannot exceed. Where there
// is none, or samples are not finite, there is no distance; such points are counted, not left out in silence.
#pragma once

#include <span>

#include "base/context.hpp"
#include "extract/extractor.hpp"
#include "field/interpolant.hpp"
#include "measure/error_statistics.hpp"
#include "mesh/half_space.hpp"

namespace isoextract::measure {

struct FieldErrorOptions {
  field::Interpolation interpolation = field::Interpolation::trilinear;  // whose isosurface is the truth
  double reach = 1;                                                      // voxels of the field
  const field::ScalarField* grid = nullptr;    // that the mesh was extracted from, if resample() made it of the field
  bool vertices_on_edges = true;               // MethodTraits::vertices_on_edges: else there is no `storage` error
  std::span<const mesh::HalfSpace> cuts = {};  // that are capped: triangles in their planes are caps, too
};

struct FieldError {
  field::Interpolation interpolation = field::Interpolation::trilinear;
  ErrorStatistics interior;  // at seven points inside each triangle (quadrature.hpp), weighted by area
  ErrorStatistics vertices;  // at the vertices, each alike

  // At vertices on edges along the samples' axes, against the trilinear interpolant, whose crossing there is exact:
  // what float32 positions and the margin at the ends of edges (extract/edge_geometry.hpp) cost. Marching tetrahedra
  // have vertices on diagonals besides, where the interpolant is not linear; those are in `vertices` only. Without
  // points where the mesh is from another grid, whose edges are not the field's, and where the method's vertices are
  // not on edges.
  ErrorStatistics storage;

  std::uint64_t cap_triangles = 0;  // not measured: they lie in the border of the data or a cut, not on the isosurface
};

// Of methods that follow the interpolant (MethodTraits). `extracted` is how `mesh` was extracted, from `field` or from
// the grid in `options`: iso value, placement, region and cap are taken from it. The mesh may have fewer triangles
// since. Voxels are those of `field`. The same answer for any number of threads.
[[nodiscard]] FieldError measure_field_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                                             const extract::ExtractOptions& extracted, const FieldErrorOptions& options,
                                             const Context& context = Context());

}  // namespace isoextract::measure
