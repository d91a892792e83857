// Fewer triangles for a patch of a surface: vertices are collapsed into neighbours, the least error first.
//
// - Error: the greatest distance of vertices that went to the new triangles, after Klein, Liebich, Strasser: Mesh
//   reduction with error control. IEEE Visualization 1996; that of the middles of new edges to the original mesh; or
//   the quadric error (Garland, Heckbert: Surface simplification using quadric error metrics. SIGGRAPH 1997), whichever
//   is greatest. Quadric errors cost little: points are looked at where these say that it is a vertex's turn. Where
//   many vertices belong to one triangle, the farthest are kept.
// - Topology: a vertex is only collapsed where the link condition holds (Dey, Edelsbrunner, Guha, Nekhayev: Topology
//   preserving edge contraction. Publ. Inst. Math. 66, 1999), and no triangle turns over or loses its area. Vertices of
//   open borders move along them, and planes upright on their edges belong to the quadrics.
//
// The order hardly knows the limit: second choices are looked at where the first is beyond it, and `proven` refuses
// some. Points prove nothing; distance_proof.hpp does.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "edit/detail/collapse_state.hpp"

namespace isoextract::edit {

struct CollapseLimits {
  double distance = std::numeric_limits<double>::infinity();
  // That no point of a new triangle may have from the original mesh. Triangles whose points come near to it are
  // bounded.
  double proven = std::numeric_limits<double>::infinity();
  std::size_t triangles = 0;  // of the patch: no fewer, if it can be told
};

// Which vertices of the mesh a round leaves alone, and which it looks at first: others come into question where
// something around them changes.
struct CollapseVertices {
  std::span<const char> locked;
  std::span<const char> wanted;
};

// `patch` are triangles of the state that are there. No vertex that is locked moves, and no new edge joins two of
// these, so patches that share locked vertices alone may be worked on at once. Every vertex has all its triangles in
// the patch, or is locked. The surface keeps its components, its border's loops and its Euler number, and is manifold
// wherever it was; where it is not, its vertices stay. Collapses are numbered from `first`.
[[nodiscard]] CollapseLog collapse_edges(CollapseState& state, std::span<const std::uint32_t> patch,
                                         const CollapseVertices& vertices, const CollapseLimits& limits,
                                         std::uint32_t first);

}  // namespace isoextract::edit
