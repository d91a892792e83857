// The stage that measures how far a mesh is from its isosurface.
#pragma once

#include <optional>
#include <span>

#include "base/context.hpp"
#include "convert/json_values.hpp"
#include "measure/analytic_error.hpp"
#include "measure/field_error.hpp"

namespace isoextract::convert {

struct MeshError {
  double iso = 0;
  measure::FieldError field;
  std::optional<measure::AnalyticError> analytic;  // of demo fields with a formula
  std::optional<field::SurfaceSize> exact;  // likewise, where their size is known, in the mesh's units; not of a part
  bool of_part = false;                     // then: a region or a clip may have left some of it out
};

// Changes of a mesh since its extraction.
struct MeshChanges {
  bool off_edges = false;    // its vertices may have left the edges between samples
  double simplified_by = 0;  // voxels: how far simplification moved it at most, caps as well
};

// `extracted` is how the mesh was extracted from `field`, or from `grid` if there is one, which was made of it by
// resample() or by blurring. `clipped` is what of it was kept since. Fails as measure_field_error() does.
[[nodiscard]] Result<MeshError> measure_mesh_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                   const extract::ExtractOptions& extracted,
                                                   field::Interpolation interpolation, const field::ScalarField* grid,
                                                   std::span<const mesh::HalfSpace> clipped, const MeshChanges& changes,
                                                   const Context& context);

// "error" of a mesh in docs/report.schema.json.
[[nodiscard]] Json json_of(const MeshError& error);

}  // namespace isoextract::convert
