// How far a mesh is from the isosurface of the data it came from, and that from the mesh.
//
// Distances are those to the nearest point. The isosurface is that of an interpolant, which is extracted anew, brick by
// brick and in parts of cells (detail/subdivided_surface.hpp). From points of the mesh the nearest point of those
// triangles is looked for, and from there the nearest one of the isosurface itself; a point whose surface may be
// beyond the bricks around it is measured from that of all data, in whole cells. The other way, points on the
// isosurface, several in each cell, are measured to the nearest triangle of the mesh.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "accuracy/cap_places.hpp"
#include "accuracy/error_statistics.hpp"
#include "accuracy/surface_coverage.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "extract/extractor.hpp"
#include "field/interpolant.hpp"
#include "mesh/half_space.hpp"

namespace isoextract::accuracy {

struct FieldErrorOptions {
  field::Interpolation interpolation = field::Interpolation::trilinear;  // whose isosurface is the truth
  const field::ScalarField* grid = nullptr;  // that the mesh was extracted from, if resample() made it of the field
  bool vertices_on_edges = true;             // MethodTraits::vertices_on_edges: else there is no `storage` error
  CapPlaces caps = {};
  std::span<const mesh::HalfSpace> clipped = {};  // what was kept of the mesh: no other part of the isosurface counts
};

struct FieldError {
  field::Interpolation interpolation = field::Interpolation::trilinear;
  // From the mesh to the isosurface: at seven points inside each triangle, or each part of a large one
  // (quadrature.hpp), weighted by area. The maximum is that of the vertices, too.
  ErrorStatistics interior;
  ErrorStatistics vertices;  // at the vertices, each alike

  // At vertices on edges along the samples' axes, against the trilinear interpolant, whose crossing there is exact:
  // what float32 positions and the margin at the ends of edges (extract/edge_geometry.hpp) cost. Marching tetrahedra
  // have vertices on diagonals besides, where the interpolant is not linear; those are in `vertices` only. Without
  // points where the mesh is from another grid, whose edges are not the field's, and where the method's vertices are
  // not on edges.
  ErrorStatistics storage;

  // Not measured: they lie in the data boundary or a cut, or beyond the outermost samples, not on the isosurface.
  std::uint64_t cap_triangles = 0;

  int parts = 0;  // into which cells were divided along each axis
  // From the isosurface to the mesh. Nothing where a region holds no whole cell of the field.
  std::optional<SurfaceCoverage> coverage;
};

// `extracted` is how `mesh` was extracted, from `field` or from the grid in `options`: iso value, placement, region and
// cap are taken from it. The mesh may have been changed since. Voxels are those of `field`. Memory is reserved. Fails
// as an extraction of the field does. The same answer for any number of threads.
[[nodiscard]] Result<FieldError> measure_field_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                     const extract::ExtractOptions& extracted,
                                                     const FieldErrorOptions& options, const Context& context);

// What that takes at least beside the mesh, with so many triangles of it and of the isosurface in whole cells.
[[nodiscard]] std::uint64_t field_error_bytes(std::uint64_t mesh_triangles, std::uint64_t surface_triangles);

}  // namespace isoextract::accuracy
