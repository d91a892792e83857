// Whether a mesh whose edges were collapsed is within a distance of what it was, in both directions, at every point;
// and collapses taken back where it is not.
//
// A triangle that is too far away has the last collapse undone that changed it, or what is nearest to it. That leads
// back to the original mesh in the end, so it comes to an end; mostly a few collapses of thousands are enough.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "edit/detail/collapse_state.hpp"
#include "mesh/greatest_distance.hpp"

namespace isoextract::edit {

struct ProofOptions {
  double enough = 0;     // the distance that is to be proven, finite
  bool once = false;     // what is too far away is undone, and nothing is measured again: nothing is proven then
  double cell_size = 1;  // of a grid by which triangles near to changes are found again; a few triangles wide
};

struct Proof {
  double lower = 0;  // of the Hausdorff distance
  double upper = 0;
  std::uint64_t undone = 0;            // collapses
  std::vector<std::uint32_t> refused;  // the vertices whose collapses were not to be; others had to be undone for them
  int passes = 0;                      // measurements, the first of the whole mesh
};

// What it takes for each triangle of the original mesh, beside the state and a tree: what is known of it, which are in
// doubt, and those that are there.
inline constexpr std::uint64_t kProofTriangleBytes =
    sizeof(KnownDistance) + 6 * sizeof(std::uint32_t) + sizeof(glm::uvec3) + 1;

// Fails where the context is cancelled. The same for any number of threads.
[[nodiscard]] Result<Proof> prove_distance(CollapseState& state, std::span<const CollapseLog> logs,
                                           const ProofOptions& options, const Context& context);

// What measure_distance() takes, likewise; and for each vertex.
inline constexpr std::uint64_t kMeasureTriangleBytes =
    mesh::GreatestDistanceSearch::bytes(0, 1) + sizeof(glm::uvec3) + 2;
inline constexpr std::uint64_t kMeasureVertexBytes = mesh::GreatestDistanceSearch::bytes(1, 0);

// The distance as it is: nothing is taken back. The interval is no wider than a fiftieth of it and what float
// resolves, but where a triangle would take millions of parts.
[[nodiscard]] Result<Proof> measure_distance(const CollapseState& state, const Context& context);

}  // namespace isoextract::edit
