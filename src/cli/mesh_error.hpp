// What `--error` measures of a mesh, and how it is told.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "convert/json_values.hpp"
#include "measure/analytic_error.hpp"
#include "measure/field_error.hpp"

namespace isoextract::cli {

struct MeshError {
  double iso = 0;
  measure::FieldError field;
  std::optional<measure::AnalyticError> analytic;  // of demo fields with a formula
  std::optional<field::SurfaceSize> exact;         // likewise, where their size is known, in the mesh's units
};

// `extracted` is how the mesh was extracted from `field`, or from `grid` if there is one, which resample() made of it.
[[nodiscard]] MeshError measure_mesh_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                                           const extract::ExtractOptions& extracted, field::Interpolation interpolation,
                                           const field::ScalarField* grid, const Context& context);

// "trilinear", "tricubic": the spelling of --error.
[[nodiscard]] std::string_view interpolation_name(field::Interpolation interpolation);

// The lines that every run with --error shows: the distance, and what could not be measured.
[[nodiscard]] std::vector<std::string> error_summary(const MeshError& error);
// What --explain adds: vertices, storage, what was left out.
[[nodiscard]] std::vector<std::string> error_details(const MeshError& error);

// For the report: "error" of a mesh in docs/report.schema.json.
[[nodiscard]] convert::Json json_of(const MeshError& error);

}  // namespace isoextract::cli
