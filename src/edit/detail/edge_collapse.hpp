// Collapses vertices of a patch into neighbors, the least error first.
//
// - Error: the largest of three. First, the distance of removed vertices to the new triangles (Klein, Liebich,
//   Strasser: Mesh reduction with error control. IEEE Visualization 1996). Second, the distance of the midpoints of new
//   edges to the original mesh. Third, the quadric error (Garland, Heckbert: Surface simplification using quadric error
//   metrics. SIGGRAPH 1997), which is cheap: it decides when a vertex's points are measured. A triangle keeps only its
//   farthest samples.
// - Topology: a vertex collapses only if the link condition holds (Dey, Edelsbrunner, Guha, Nekhayev: Topology
//   preserving edge contraction. Publ. Inst. Math. 66, 1999) and no triangle flips or loses its area. Curves are
//   boundary loops and lines where sheets meet. A vertex of a curve collapses along its curve; the ends of curves stay.
//   Planes through boundary edges, at right angles to their triangles, are part of the quadrics.
// - Intersections: with the guard, a collapse must not make triangles of the patch intersect (intersection_guard.hpp).
//
// The limits hardly change the order. If the best target of a vertex exceeds the limit `distance`, a second target is
// tried; `proven` rejects single collapses. Sample points prove nothing; distance_proof.hpp does.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "edit/detail/collapse_state.hpp"

namespace isoextract::edit {

struct CollapseLimits {
  double distance = std::numeric_limits<double>::infinity();  // largest allowed error
  // Rejects a collapse if a point of a new triangle is farther from the original mesh. Skips the measurement of
  // triangles whose samples are all nearer than half of this limit.
  double proven = std::numeric_limits<double>::infinity();
  // Rejects a collapse that makes triangles of the patch intersect. Without the guard, undo_intersections() must look
  // at all pairs before the next round with it.
  bool is_guarded = true;
  std::size_t triangles = 0;  // of the patch: stop here, or a few below (collapse_state.hpp: triangles of a collapse)
};

// `locked`: vertices that this round must not move. `wanted`: vertices tried first; other vertices are tried once a
// collapse changes their surroundings.
struct CollapseVertices {
  std::span<const char> locked;
  std::span<const char> wanted;
};

// Collapses edges of `patch`, existing triangles of the state. Returns the log; numbers collapses from `first`.
//
// Moves no locked vertex and joins no two locked vertices by a new edge, so patches that share only locked vertices can
// run in parallel. Every vertex must have all its triangles in the patch or be locked. Keeps components, boundary
// loops, sheets, Euler number and manifoldness. Vertices stay where the surface is neither a manifold nor sheets
// around one curve.
[[nodiscard]] CollapseLog collapse_edges(CollapseState& state, std::span<const std::uint32_t> patch,
                                         const CollapseVertices& vertices, const CollapseLimits& limits,
                                         std::uint32_t first);

}  // namespace isoextract::edit
