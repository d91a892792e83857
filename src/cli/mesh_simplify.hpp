// What `--simplify` does to a mesh, and how it is told.
#pragma once

#include <string>
#include <vector>

#include "batch/conversion_report.hpp"
#include "cli/values.hpp"
#include "field/affine.hpp"
#include "measure/bounded_simplify.hpp"

namespace isoextract {

struct MeshSimplification {
  SimplificationRecord record;
  Simplification facts;
};

// `mesh` was placed by `output_from_index`, whose linear part says what a voxel is. It is replaced by what is left.
[[nodiscard]] MeshSimplification simplify_mesh(Mesh& mesh, double iso, const SimplifyError& error,
                                               const Affine& output_from_index, Progress* progress);

// The line that every run with --simplify shows, and what --explain adds.
[[nodiscard]] std::string simplification_summary(const MeshSimplification& simplification);
[[nodiscard]] std::string simplification_details(const MeshSimplification& simplification);

}  // namespace isoextract
