// Proves that a mesh with collapsed edges is within a distance of the original, in both directions and at every point;
// undoes collapses where it is not.
//
// Undoes the last collapse of each changed triangle that is too far away. For an original triangle too far away, undoes
// the last collapse of the triangle nearest to its centroid. This ends at the start of the state at the latest, where
// all distances are proven; usually a few collapses of thousands are undone. An original triangle may be too far away
// although neither it nor its nearest triangle has changed since the start: then undoes all collapses near it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "edit/detail/collapse_state.hpp"
#include "mesh/greatest_distance.hpp"

namespace isoextract::edit {

struct DistanceProofOptions {
  double enough = 0;         // the distance to prove; finite
  bool once = false;         // undo once, do not measure again: proves nothing
  double original_size = 1;  // about the width of large original triangles
};

struct Proof {
  double lower = 0;  // bounds of the Hausdorff distance
  double upper = 0;
  std::uint64_t undone = 0;  // undone collapses
  // With `once`: the vertices whose collapses went too far. Collapses that were undone only because they depend on
  // these are not listed.
  std::vector<std::uint32_t> refused;
  // Measurements; the first covers the whole mesh, or of a state with a past what changed since, unless an earlier
  // proof is taken up.
  int passes = 0;
};

// The distances that a proof found. A later proof of the same state then measures only what undone collapses changed.
struct ProvenDistances {
  std::vector<DistanceBounds> original;    // of each original triangle to the simplified mesh; empty: none measured yet
  std::vector<RestoredTriangle> restored;  // by collapses undone after the proof, or by the proof itself
};

// Bytes for each triangle of the original mesh, without the state and the trees.
inline constexpr std::uint64_t kProofTriangleBytes =
    sizeof(DistanceBounds) + 9 * sizeof(std::uint32_t) + sizeof(glm::uvec3) + 2 + 2 * SurfaceCover::kTriangleBytes;

// Undoes collapses in `state` until the distance is proven. The result does not depend on the number of threads. Takes
// up an earlier proof if `proven` holds one: no edge may have been collapsed since, and `proven.restored` must list the
// triangles restored since. Sets both members of `proven`. Fails if the context is cancelled.
[[nodiscard]] Result<Proof> prove_distance(CollapseState& state, std::span<const CollapseLog> logs,
                                           const DistanceProofOptions& options, ProvenDistances& proven,
                                           const Context& context);

// Bytes that measure_distance() uses for each triangle and each vertex, without the state and the trees.
inline constexpr std::uint64_t kMeasureTriangleBytes =
    mesh::GreatestDistanceSearch::bytes(0, 1) + sizeof(glm::uvec3) + 2;
inline constexpr std::uint64_t kMeasureVertexBytes = mesh::GreatestDistanceSearch::bytes(1, 0);

// Measures the distance and undoes nothing. The width of the interval is at most 2 % of the distance plus the float32
// resolution, except where a triangle would have to be cut into millions of parts.
[[nodiscard]] Result<Proof> measure_distance(const CollapseState& state, const Context& context);

}  // namespace isoextract::edit
