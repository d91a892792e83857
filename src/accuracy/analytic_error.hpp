// Measures how far a mesh of a demo field is from the exact surface of its formula.
#pragma once

#include <optional>
#include <span>

#include "accuracy/cap_planes.hpp"
#include "accuracy/error_statistics.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "extract/extractor.hpp"
#include "field/analytic_field.hpp"

namespace isoextract::accuracy {

// Angles between normals, weighted by area.
struct AngleStatistics {
  std::uint64_t points = 0;
  double rms_degrees = 0;
  double max_degrees = 0;
};

struct AnalyticError {
  // True: distances and normals are known in closed form (sphere, torus). False: an iteration finds the nearest point
  // of the surface. It starts on a mesh of the formula that is at least as fine as the samples.
  bool closed_form = false;
  // True distance at seven points inside each triangle, or inside each part of a triangle with a side longer than 1.75
  // voxels (detail/quadrature.hpp), weighted by area. The maximum includes the vertices. `unreached` counts points
  // where no iteration converged.
  ErrorStatistics interior;
  ErrorStatistics vertices;
  // Normals interpolated across the triangle, as a renderer does; no points if the mesh has no normals.
  AngleStatistics smooth_normals;
  AngleStatistics flat_normals;  // normals of the triangles themselves

  double area = 0;               // without caps, in the mesh's units
  std::optional<double> volume;  // absent with a region, or if neither closed_form nor ExtractOptions::cap is true
  double unit = 1;               // the formula's unit of length, in the mesh's units

  std::uint64_t cap_triangles = 0;  // counted in the volume only
};

// Measures `mesh`, extracted with options `extracted` from the demo field `field`, or from `grid`, which resample()
// made of `field`. Returns nothing if there is no formula, or if the placement is no similarity and so distorts
// distances. Fails as an extraction from the formula does: with ErrorCode::out_of_memory or ErrorCode::cancelled. The
// result does not depend on the number of threads.
[[nodiscard]] Result<std::optional<AnalyticError>> measure_analytic_error(
    const mesh::Mesh& mesh, const field::ScalarField& field, const extract::ExtractOptions& extracted,
    const field::ScalarField* grid, const CapPlanes& caps, const Context& context);

}  // namespace isoextract::accuracy
