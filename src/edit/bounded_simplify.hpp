// Simplifies a mesh to a largest distance, to a number of triangles, or to both. The distance between result and input
// is bounded in both directions at every point, not only at vertices.
//
// Edges are collapsed in patches that run in parallel; vertices shared by patches stay (detail/edge_collapse.hpp). The
// next round takes the vertices between patches, with larger patches, until one patch holds all that is left: so no
// patch border remains visible. A large distance is approached through smaller ones, each with all its rounds, so that
// it never leaves more triangles than a small one. During collapses, sample points of the input estimate the distance.
// Afterwards the distance is proven for every point, and collapses that went too far are undone
// (detail/distance_proof.hpp). A number of triangles is reached by growing distances; the final distance is then
// measured.
//
// Distances are bounded triangle by triangle as in mesh/distance_bound.hpp. The result does not depend on the number of
// threads.
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
  // The largest allowed distance, in the space of to_metric; infinity: no limit but `triangles`.
  double max_distance = 0;
  std::uint64_t triangles = 0;  // stop here, or one triangle below; 0: no target
  // Maps the mesh's coordinates to the space in which distances are measured, for example voxels as unit cubes.
  glm::dmat3 to_metric{1.0};
  double patch_size = 32;  // side of the first patches in that space; some tens of the mesh's triangles
};

struct SimplifyFigures {
  // Lower and upper bound of the Hausdorff distance between result and input, in the space of to_metric. The upper
  // bound never exceeds max_distance.
  double distance_lower = 0;
  double distance_upper = 0;
  std::uint64_t triangles_before = 0;
  std::uint64_t triangles_after = 0;
  std::uint64_t patches = 0;           // in all rounds
  std::uint64_t collapses = 0;         // collapsed edges, including those undone later
  std::uint64_t undone_collapses = 0;  // collapses undone because a triangle was too far away
  int rounds = 0;
  int passes = 0;  // distance measurements: the first, and one more after each undo
  StageTime time;
};

struct SimplifiedMesh {
  mesh::Mesh mesh;
  SimplifyFigures facts;
};

// Returns the simplified mesh and its figures.
//
// Keeps a subset of the vertices, in their order, with their normals and attributes; edge keys are dropped. Vertices of
// open borders collapse only along their border. A manifold stays a manifold with the same components, boundary loops
// and Euler number; that can need more triangles than were asked for. Adds no zero-area triangle and no duplicate
// triangle. Returns the mesh unchanged if no collapse is possible.
//
// Fails if the working memory (about 400 bytes a triangle) exceeds the budget, or if the context is cancelled.
[[nodiscard]] Result<SimplifiedMesh> simplify_mesh(mesh::Mesh mesh, const SimplifyOptions& options,
                                                   const Context& context);

}  // namespace isoextract::edit
