// What `--simplify` does to a mesh, and how it is told.
#pragma once

#include <string>
#include <vector>

#include "cli/values.hpp"
#include "convert/conversion_report.hpp"
#include "edit/bounded_simplify.hpp"
#include "field/affine.hpp"

namespace isoextract::cli {

struct MeshSimplification {
  convert::SimplificationRecord record;
  edit::Simplification facts;
};

// `mesh` was placed by `output_from_index`, whose linear part says what a voxel is. It is replaced by what is left.
[[nodiscard]] Result<MeshSimplification> simplify_mesh(mesh::Mesh& mesh, double iso, const SimplifyError& error,
                                                       const field::Affine& output_from_index, Progress* progress);

// The line that every run with --simplify shows, and what --explain adds.
[[nodiscard]] std::string simplification_summary(const MeshSimplification& simplification);
[[nodiscard]] std::string simplification_details(const MeshSimplification& simplification);

}  // namespace isoextract::cli
