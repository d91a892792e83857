// Fewer triangles for a patch of a surface: vertices are collapsed into neighbours, the least quadric error first.
//
// - Order: quadric errors (Garland, Heckbert: Surface simplification using quadric error metrics. SIGGRAPH 1997).
// - Topology: a vertex is only collapsed where the link condition holds (Dey, Edelsbrunner, Guha, Nekhayev: Topology
//   preserving edge contraction. Publ. Inst. Math. 66, 1999), and no triangle turns over or loses its area.
// - Distance: each vertex that went stays attached to the triangle nearest to it, and no collapse takes any of them
//   farther than allowed (after Klein, Liebich, Strasser: Mesh reduction with error control. IEEE Visualization 1996).
//
// meshoptimizer 0.18, of Debian 12, has none of the latter two: its collapses leave edges of four triangles, triangles
// back to back and, in flat regions, triangles without area, and its error is a root mean square.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::edit {

struct Face {
  glm::uvec3 corners;                     // vertices of the mesh, counter-clockwise seen from outside
  std::vector<std::uint32_t> represents;  // vertices of the mesh that went, and are nearest to this face
};

using FaceFilter = std::function<bool(const glm::uvec3& corners)>;

// `patch` are faces of a mesh whose positions are given. The result uses vertices of the patch, in place of which it
// can stand: it has the patch's border, edge by edge, its components and its Euler number, it is manifold wherever the
// patch is, and no new edge joins two vertices of the border, so that patches on both sides may be simplified by
// themselves. It has no triangle without area that the patch has not, and none twice. Every vertex that went, now or
// earlier
// (`represents`), is at most `distance` from a face, and every new face is one that `allowed` says yes to; it is asked
// by the face's corners. Where the patch is not manifold, its vertices stay.
[[nodiscard]] std::vector<Face> simplify_patch(std::span<const glm::vec3> positions, std::vector<Face> patch,
                                               double distance, const FaceFilter& allowed);

}  // namespace isoextract::edit
