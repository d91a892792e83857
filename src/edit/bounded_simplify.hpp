// Simplifies a mesh to a largest distance, to a number of triangles, or to both. The distance between result and input
// is bounded in both directions at every point, not only at vertices.
//
// Edges are collapsed in patches that run in parallel; vertices shared by patches stay (detail/edge_collapse.hpp). The
// next round visits these vertices and their surroundings in larger patches, so that they become interior, until only
// one patch is left. So no outline of a patch remains visible. The distance limit rises in steps, each with all its
// rounds, so that a larger limit never gives more triangles than a smaller one. During collapses, sample points of the
// input estimate the distance. Afterwards the distance is proven for every point, and collapses that went too far are
// undone (detail/distance_proof.hpp). For a triangle target, the limit rises until the target is near or few patches
// are left. Then one patch collapses the cheapest edges first, down to the target, and the final distance is measured.
//
// No triangles intersect that did not before (mesh/self_intersections.hpp). Most rounds have a guard: it refuses
// collapses that would make triangles of their patch intersect (detail/intersection_guard.hpp). The first rounds of a
// small distance have none. Collapses after which triangles do intersect, of one patch or of several, are undone
// (detail/intersection_undo.hpp). Where triangles intersect already, the number of intersecting pairs does not grow. So
// a mesh without intersections stays one, which printing needs.
//
// Distances are bounded triangle by triangle as in mesh/distance_bound.hpp. The result does not depend on the number of
// threads. A mesh too large for the memory budget is simplified in windows (detail/simplify_windows.hpp).
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct SimplifyOptions {
  // The largest allowed distance, in the space of to_metric; 0: no simplification; infinity: no limit but `triangles`.
  double max_distance = 0;
  // Target: the result has this number of triangles or one fewer, but more if max_distance or the topology requires it.
  // 0: no target.
  std::uint64_t triangles = 0;
  // Maps the mesh's coordinates to the space in which distances are measured, for example voxels as unit cubes.
  glm::dmat3 to_metric{1.0};
  double patch_size = 32;  // side length of the first patches in that space: some tens of triangle edges
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
  // Collapses that the guard refused because they would have made triangles intersect; a collapse tried again counts
  // again. Rounds without the guard refuse none.
  std::uint64_t refused_collapses = 0;
  std::uint64_t untangled_collapses = 0;  // collapses undone because triangles intersected afterwards
  int rounds = 0;
  int passes = 0;             // distance measurements, which are repeated after each undo
  std::uint64_t windows = 0;  // parts that were simplified one after the other; 0: the mesh was simplified as a whole
  StageTime time;
};

struct SimplifiedMesh {
  mesh::Mesh mesh;
  SimplifyFigures facts;
};

// Returns the simplified mesh and its figures.
//
// Keeps a subset of the vertices, in their order, with their normals and attributes; edge keys are dropped. Vertices of
// boundary loops collapse only along their loop. A manifold stays a manifold with the same components, boundary loops
// and Euler number; that can need more triangles than were asked for. Adds no zero-area triangle and no duplicate
// triangle. Returns the mesh unchanged if no collapse is possible.
//
// The whole mesh takes about 520 bytes a triangle, with a target 750. If the budget has less, windows of as many
// triangles as fit are simplified one after the other: the result then depends on the budget. With a target, windows
// remove triangles by small distances until the rest fits as a whole. Fails with ErrorCode::out_of_memory if that is
// impossible, too, with ErrorCode::input if the rounds of a window visit 2^32 - 1 triangles or more, or with
// ErrorCode::cancelled.
[[nodiscard]] Result<SimplifiedMesh> simplify_mesh(mesh::Mesh mesh, const SimplifyOptions& options,
                                                   const Context& context);

// Returns how many triangles simplify_mesh() holds in its buffers at once if the budget has `left` bytes besides the
// mesh: all, or those of a window. `target` is options.triangles.
[[nodiscard]] std::uint64_t simplified_at_once(std::uint64_t vertices, std::uint64_t triangles, std::uint64_t target,
                                               std::uint64_t left);

}  // namespace isoextract::edit
