// The stage that simplifies a mesh: from a bound in voxels or world units to edit's metric, and back to both.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/stopwatch.hpp"
#include "convert/conversion_job.hpp"
#include "edit/bounded_simplify.hpp"
#include "field/affine.hpp"

namespace isoextract::convert {

struct DistanceRange {
  double lower = 0;
  double upper = 0;
};

// Of a mesh that was simplified: the Hausdorff distance to what it was, at least and at most.
struct MeshSimplification {
  double iso = 0;
  SimplifyBound asked;
  DistanceRange voxels;
  DistanceRange world;  // in the mesh's units
  edit::Simplification facts;
};

// `mesh` was placed by `output_from_index`, whose linear part says what a voxel is. It is replaced by what is left.
// Fails as edit::simplify_within() does.
[[nodiscard]] Result<MeshSimplification> simplify_mesh(mesh::Mesh& mesh, double iso, const SimplifyBound& bound,
                                                       const field::Affine& output_from_index, const Context& context);

}  // namespace isoextract::convert
