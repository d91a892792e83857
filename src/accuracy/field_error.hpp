// Measures how far a mesh is from the isosurface of its data, and the isosurface from the mesh.
//
// Distances are to the nearest point, except FieldError::storage. From a point of the mesh, the program searches along
// the gradient (detail/gradient_search.hpp). If that may miss the nearest point, it finds the nearest triangle of the
// isosurface, then the nearest point of the isosurface itself. For this, it extracts the isosurface again: brick by
// brick on cells divided into subcells (detail/subdivided_surface.hpp), and of all data on undivided cells. In the
// other direction, several isosurface points in each cell are measured to the nearest triangle of the mesh.
//
// Large surfaces are measured in windows, one after the other, so that little memory grows with the surface: some bytes
// for each brick and for each component. The windows depend on the surface only. A window that is too small to find the
// nearest triangles is measured again, with a larger margin. Surfaces with NaN holes are measured as a whole.
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

// Surfaces with more triangles are measured in windows of about this size.
inline constexpr std::uint64_t kWindowTriangles = 1 << 19;

struct FieldErrorOptions {
  field::Interpolation interpolation = field::Interpolation::trilinear;  // its isosurface is the reference
  // The grid that the mesh was extracted from, if it was made from the field by resampling or blurring; else null.
  const field::ScalarField* grid = nullptr;
  bool vertices_on_edges = true;  // MethodTraits::vertices_on_edges; if false, FieldError::storage is not measured
  CapPlanes caps = {};
  // Half-spaces that the mesh was clipped to; isosurface outside them does not count.
  std::span<const mesh::HalfSpace> clipped = {};
  std::uint64_t window_triangles = kWindowTriangles;
};

struct FieldError {
  field::Interpolation interpolation = field::Interpolation::trilinear;
  // Distances from the mesh to the isosurface, weighted by area. Triangles with a side longer than 1.75 voxels are
  // divided into smaller ones; each triangle is measured at seven points inside it (detail/quadrature.hpp). The maximum
  // includes the vertices.
  ErrorStatistics interior;
  ErrorStatistics vertices;  // at the vertices, equally weighted

  // Error of storing positions: distances of the vertices on axis-aligned grid edges from the isosurface of the
  // trilinear interpolant, which contains the exact crossings. Measured by the search along the gradient alone.
  // Contains only the rounding to float32 and the shift of vertices away from the ends of their edges
  // (extract/edge_geometry.hpp). Vertices of marching tetrahedra on diagonals are in `vertices` only. Has no points
  // with FieldErrorOptions::grid, or if the method has no vertices on edges.
  ErrorStatistics storage;

  // Triangles that were not measured: caps at the data boundary and in clip planes, and triangles beyond the outermost
  // samples.
  std::uint64_t cap_triangles = 0;

  int parts = 0;  // subcells of a cell along each axis
  // From the isosurface to the mesh. Absent if the region contains no whole cell of the field.
  std::optional<SurfaceCoverage> coverage;
};

// Measures `mesh`, which may have been edited after it was extracted with options `extracted` from `field`, or from the
// grid in `options`. Uses the iso value, transform, region and cap of `extracted`; distances in voxels refer to
// `field`. Fails as an extraction of the field does, or if memory is short. The result does not depend on the number of
// threads.
[[nodiscard]] Result<FieldError> measure_field_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                     const extract::ExtractOptions& extracted,
                                                     const FieldErrorOptions& options, const Context& context);

// Measures the mesh that an extraction with options `extracted` makes, without holding it: extracts it again, window by
// window. `extracted` must not ask for a cap, and with a region, output_placement() (extract/edge_geometry.hpp) must
// be that of the whole field. The method must follow the interpolant (MethodTraits), and the mesh must have triangles.
// `options` must have no grid, caps and half-spaces. The result is that of measure_field_error(), and so are failures.
[[nodiscard]] Result<FieldError> measure_extraction_error(const field::ScalarField& field,
                                                          const extract::ExtractOptions& extracted,
                                                          const FieldErrorOptions& options, const Context& context);

// Memory that a measurement needs beside the mesh and the field.
struct ErrorMemory {
  std::uint64_t least = 0;  // no measurement needs less
  std::uint64_t usual = 0;  // an estimate
};

// Returns the memory of a measurement. `surface_triangles` is the size of the isosurface extracted on undivided cells;
// it may be a quarter too low.
[[nodiscard]] ErrorMemory field_error_memory(const field::ScalarField& field, std::uint64_t mesh_triangles,
                                             std::uint64_t surface_triangles);

}  // namespace isoextract::accuracy
