// How far a mesh of a demo field is from the true surface of its formula.
#pragma once

#include <optional>
#include <span>

#include "accuracy/cap_places.hpp"
#include "accuracy/error_statistics.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "extract/extractor.hpp"
#include "field/analytic_field.hpp"

namespace isoextract::accuracy {

// Of angles between normals, weighted by area.
struct AngleStatistics {
  std::uint64_t points = 0;
  double rms_degrees = 0;
  double max_degrees = 0;
};

struct AnalyticError {
  // Distances and normals: in closed form (sphere, torus), or of the point that iterations come to from the nearest one
  // of a mesh of the formula, which is as fine as the samples or finer.
  bool closed_form = false;
  ErrorStatistics interior;  // true distance at seven points inside each triangle, or each part of a large one, by
                             // area; the maximum is that of the vertices, too; `unreached`: no iteration ended
  ErrorStatistics vertices;
  AngleStatistics
      smooth_normals;  // interpolated across the triangle, as a renderer does; without points if there are none
  AngleStatistics flat_normals;  // the triangles' own

  double area = 0;               // of the triangles that are no cap, in the mesh's units
  std::optional<double> volume;  // only of a mesh that the cap or the formula makes closed
  double unit = 1;               // what the formula's unit of length is in the mesh's

  std::uint64_t cap_triangles = 0;  // in the volume only
};

// `extracted` is how `mesh` was extracted from `field`, which must be a demo field, or from `grid` if there is one,
// which resample() made of it. Nothing where there is no formula, or where the placement is more than a turn, a scale
// and a shift, so that it stretches distances. Memory is reserved; fails where it runs out. The same answer for any
// number of threads.
[[nodiscard]] Result<std::optional<AnalyticError>> measure_analytic_error(
    const mesh::Mesh& mesh, const field::ScalarField& field, const extract::ExtractOptions& extracted,
    const field::ScalarField* grid, const CapPlaces& caps, const Context& context);

}  // namespace isoextract::accuracy
