// Fewer triangles within a stated distance, or a stated number of them: what comes out is measured against what went
// in, and where a distance is asked for never farther from it, in both directions, at any point.
//
// Edges are collapsed in patches, side by side, whose common vertices stay (detail/edge_collapse.hpp). What stayed for
// that reason has its turn in the next round, whose patches are larger; in the last round all that is left is one
// patch, so nothing of the patches is seen in the end. A large distance is reached by way of small ones, each of which
// has all these rounds: more triangles than for a small one are not left. Points of the mesh that came in tell on the
// way how far away new triangles are. What they cannot tell, every point of both surfaces, is proven afterwards, and
// collapses that went too far are taken back (detail/distance_proof.hpp). A number of triangles is reached by distances
// that grow, and the distance measured in the end.
//
// Distances are bounded triangle by triangle as in distance_bound.hpp, against the mesh that came in. The result is the
// same for any number of threads.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct SimplifyOptions {
  // In the space that to_metric leads to; infinity: as far as the number of triangles asks for.
  double max_distance = 0;
  std::uint64_t triangles = 0;  // no fewer than these, but one
  // From the mesh's coordinates to the space in which distances are meant: for voxels, where a voxel is a unit cube.
  glm::dmat3 to_metric{1.0};
  double patch_size = 32;  // side of the first patches, in that space; some tens of the mesh's triangles
};

struct Simplification {
  // The Hausdorff distance of the result to the mesh that came in: at least, at most, in the space of to_metric. Never
  // above max_distance.
  double measured_lower = 0;
  double measured_upper = 0;
  std::uint64_t triangles_before = 0;
  std::uint64_t triangles_after = 0;
  std::uint64_t patches = 0;     // of all rounds
  std::uint64_t collapses = 0;   // of edges, those that were taken back among them
  std::uint64_t taken_back = 0;  // because something was too far away
  int rounds = 0;
  int passes = 0;  // times that the result was measured: once more each time that collapses were taken back
  StageTime time;
};

struct SimplifiedMesh {
  mesh::Mesh mesh;
  Simplification facts;
};

// The result has some of the mesh's vertices, with all that belongs to them but edge keys, in their order. Vertices of
// open borders go where the others of the border can stand for them. Where the mesh is a manifold, so is the result,
// with as many components and borders and the same Euler number, which may need more triangles than were asked for; it
// has no triangles without area and none twice that the mesh has not. Where nothing can be gained, it is the mesh.
// Fails where its working memory, some 400 bytes a triangle, is more than is left, and where the context is cancelled.
[[nodiscard]] Result<SimplifiedMesh> simplify_within(mesh::Mesh mesh, const SimplifyOptions& options,
                                                     const Context& context);

}  // namespace isoextract::edit
