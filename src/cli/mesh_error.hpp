// What `--error` measures of a mesh, and how it is told.
#pragma once

#include <string>
#include <vector>

#include "measure/field_error.hpp"

namespace isoextract {

struct MeshError {
  double iso = 0;
  FieldError field;
};

// `extracted` is how the mesh was extracted from `field`.
[[nodiscard]] MeshError measure_mesh_error(const Mesh& mesh, const ScalarField& field, const ExtractOptions& extracted,
                                           Interpolation interpolation);

// "trilinear", "tricubic": the spelling of --error.
[[nodiscard]] std::string_view interpolation_name(Interpolation interpolation);

// The lines that every run with --error shows: the distance, and what could not be measured.
[[nodiscard]] std::vector<std::string> error_summary(const MeshError& error);
// What --explain adds: vertices, storage, what was left out.
[[nodiscard]] std::vector<std::string> error_details(const MeshError& error);

}  // namespace isoextract
