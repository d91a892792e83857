// The stage that simplifies a mesh: from a bound in voxels or world units to edit's metric, and back to both.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

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
  SimplifyChoice asked;
  std::uint64_t triangles_asked = 0;  // 0: no number was
  DistanceRange voxels;
  DistanceRange world;  // in the mesh's units
  std::uint64_t components = 0;
  std::uint64_t turned = 0;       // of them inside out, which shells thinner than the distance may be: at least so many
  std::uint64_t left_bodies = 0;  // closed components that face inward and lie in no body any more
  edit::Simplification facts;
  std::string grid = {};  // whose surface it is, where the job has several
};

// 100000 or 2.5%, as people write it.
[[nodiscard]] std::string triangle_count_text(const TriangleCount& count);
// 0.1voxel or 0.5world.
[[nodiscard]] std::string simplify_bound_text(const SimplifyBound& bound);

// What is to be told of it besides, as sentences without their full stop.
[[nodiscard]] std::vector<std::string> notes_of(const MeshSimplification& simplification);

// `mesh` was placed by `output_from_index`, whose linear part says what a voxel is. It is replaced by what is left.
// Fails as edit::simplify_within() does, and where the memory to look at its components is not there.
[[nodiscard]] Result<MeshSimplification> simplify_mesh(mesh::Mesh& mesh, double iso, const SimplifyChoice& choice,
                                                       const field::Affine& output_from_index, const Context& context);

}  // namespace isoextract::convert
