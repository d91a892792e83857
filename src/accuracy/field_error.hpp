// Measures how far a mesh is from the isosurface of its data, and the isosurface from the mesh.
//
// Distances go to the nearest point. The isosurface of an interpolant is extracted again, brick by brick and in parts
// of cells (detail/subdivided_surface.hpp). From a point of the mesh, the search finds the nearest of those triangles
// and then the nearest point of the isosurface itself. If the surface may be nearer outside the brick and its margin,
// the search uses the isosurface of all data, in whole cells. In the other direction, several isosurface points in each
// cell are measured to the nearest triangle of the mesh.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "accuracy/cap_planes.hpp"
#include "accuracy/error_statistics.hpp"
#include "accuracy/surface_coverage.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "extract/extractor.hpp"
#include "field/interpolant.hpp"
#include "mesh/half_space.hpp"

namespace isoextract::accuracy {

struct FieldErrorOptions {
  field::Interpolation interpolation = field::Interpolation::trilinear;  // its isosurface is the truth
  // Set if the mesh was extracted from a grid that resample() made of the field.
  const field::ScalarField* grid = nullptr;
  bool vertices_on_edges = true;  // MethodTraits::vertices_on_edges; false: no `storage` error
  CapPlanes caps = {};
  // Half-spaces that the mesh was clipped to; isosurface outside them does not count.
  std::span<const mesh::HalfSpace> clipped = {};
};

struct FieldError {
  field::Interpolation interpolation = field::Interpolation::trilinear;
  // From the mesh to the isosurface, at seven points inside each triangle, or each part of a large one
  // (quadrature.hpp), weighted by area. The maximum includes the vertices.
  ErrorStatistics interior;
  ErrorStatistics vertices;  // at the vertices, equally weighted

  // At vertices on axis-aligned grid edges, against the trilinear interpolant, whose crossing there is exact. This is
  // the cost of float32 positions and of the margin at edge ends (extract/edge_geometry.hpp). Vertices of marching
  // tetrahedra on diagonals are in `vertices` only. Has no points if the mesh comes from another grid, or if the method
  // puts vertices off the edges.
  ErrorStatistics storage;

  // Triangles that were not measured: on the data boundary, in a cut, or beyond the outermost samples.
  std::uint64_t cap_triangles = 0;

  int parts = 0;  // parts of a cell along each axis
  // From the isosurface to the mesh. Absent if the region contains no whole cell of the field.
  std::optional<SurfaceCoverage> coverage;
};

// Measures `mesh`, which may have been edited after it was extracted with options `extracted` from `field`, or from the
// grid in `options`. Takes iso value, placement, region and cap from `extracted`; voxels are those of `field`. Fails as
// an extraction of the field does, or if memory is short. The result does not depend on the number of threads.
[[nodiscard]] Result<FieldError> measure_field_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                     const extract::ExtractOptions& extracted,
                                                     const FieldErrorOptions& options, const Context& context);

// Returns the least memory that measure_field_error() needs beside the mesh and the field, for a mesh and an isosurface
// (in whole cells) of these sizes.
[[nodiscard]] std::uint64_t field_error_bytes(const field::ScalarField& field, std::uint64_t mesh_triangles,
                                              std::uint64_t surface_triangles);

}  // namespace isoextract::accuracy
