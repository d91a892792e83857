// Fewer triangles within a stated distance: what comes out is measured against what went in, and is never farther from
// it than asked, in both directions, at any point.
//
// The surface is cut into patches by a grid of boxes, and each patch is simplified by itself, its border locked
// (mesh/patch_simplifier.hpp); a second round with the boxes moved by half a box reaches what was border in the first.
// No new triangle is made that is farther away than asked. Where an old one gets too far from what is left, the
// triangles around it stay as they were, and the rest of the patch is simplified again. So one sharp corner costs
// triangles there and not everywhere, and patches are worked on in parallel.
//
// Distances are bounded triangle by triangle as in distance_bound.hpp, against the mesh that came in, not against the
// round before. The result is the same for any number of threads.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct SimplifyOptions {
  double max_distance = 0;  // in the space that to_metric leads to
  // From the mesh's coordinates to the space in which distances are meant: for voxels, where a voxel is a unit cube.
  glm::dmat3 to_metric{1.0};
  double patch_size = 24;  // side of the boxes, in that space
};

struct Simplification {
  double asked = 0;  // all distances in the space of to_metric
  // The Hausdorff distance of the result to the mesh that came in: at least, at most. Never above `asked`.
  double measured_lower = 0;
  double measured_upper = 0;
  std::uint64_t triangles_before = 0;
  std::uint64_t triangles_after = 0;
  std::uint64_t patches = 0;       // of all rounds
  std::uint64_t patches_kept = 0;  // of those, left as they were: nothing could be gained within what was asked
  int passes = 0;                  // times that patches were simplified and measured, over all rounds
  StageTime time;
};

struct SimplifiedMesh {
  mesh::Mesh mesh;
  Simplification facts;
};

// The result has some of the mesh's vertices, with all that belongs to them but edge keys, in
// their order. Open borders keep every
// vertex. Where the mesh is a manifold, so is the result, with as many components and the same Euler number; it has no
// triangles without area and none twice that the mesh has not. Where nothing can be gained, it is the mesh.
// Fails where its working memory, some 500 bytes a triangle, is more than is left, and where the context is cancelled.
[[nodiscard]] Result<SimplifiedMesh> simplify_within(mesh::Mesh mesh, const SimplifyOptions& options,
                                                     const Context& context = Context());

}  // namespace isoextract::edit
