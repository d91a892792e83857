// Clips a mesh to half-spaces. This is polygon clipping by Sutherland and Hodgman (Reentrant polygon clipping, Comm.
// ACM 17(1), 1974), applied to each triangle. Triangles that share an edge share the new vertex on it.
#pragma once

#include <cstdint>
#include <span>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// Whether the clipped mesh stays open where a plane cuts it.
enum class CutClosing {
  open,
  capped  // closed by triangles in the plane
};

struct ClipOptions {
  CutClosing closing = CutClosing::open;
  // Vertices within this distance of a plane move onto it. Otherwise a cut very near a vertex makes triangles so small
  // that rounding can reverse them, and they would intersect the cap.
  double snap = 0;
};

struct ClipFigures {
  std::uint64_t triangles_before = 0;
  std::uint64_t triangles_cut = 0;  // triangles that a plane crosses
  std::uint64_t triangles_after = 0;
  std::uint64_t cap_triangles = 0;  // in all caps, before later planes cut them
  // Cap triangles that overlap other cap triangles by more than rounding: the surface intersects itself there.
  std::uint64_t overlapping_cap_triangles = 0;
};

// Keeps the part of `mesh` that lies inside all half-spaces of `kept`, whose coordinates are those of mesh.origin +
// position. The edge keys are dropped if a plane cuts it. A plane changes nothing if no vertex lies outside its
// half-space by more than the larger of mesh::on_plane_tolerance() and ClipOptions::snap.
//
// At a plane that cuts, vertices within mesh::on_plane_tolerance() count as on the plane and stay. Vertices farther
// away, but within ClipOptions::snap, move onto it. Vertices may lie outside `kept` by up to the larger of these
// distances times the number of planes: a plane that cuts nothing moves no vertex, and later cuts may move a vertex
// again. Old vertices keep their order and attributes. New ones follow, with interpolated normals and attributes
// (mesh::set_interpolated()). Triangles keep order and winding. A new vertex on a shared edge is bitwise equal in two
// meshes with the same origin, on_plane_tolerance() and snap. It is also equal in the two clips to the half-spaces on
// either side of a plane. The result does not depend on the number of threads.
//
// With CutClosing::capped, triangles in the plane close each cut before the next plane cuts. They face out of the
// half-space and come after all other triangles. Triangles in the plane that bound only the removed side are dropped.
// Caps use the vertices and edges of the cut. If a cap edge would connect two vertices that share an edge already, it
// gets a new vertex at its midpoint. Vertices where loops meet are split, unless the cap joins the loops at that
// vertex. So a closed oriented manifold stays one.
//
// Fails with ErrorCode::out_of_memory or ErrorCode::cancelled, or with ErrorCode::input if a capped cut ends at a
// boundary edge of the surface, encloses no area, or needs more vertices than 32-bit indices allow. `mesh` may then be
// cut by some of the planes. Throws std::bad_alloc.
[[nodiscard]] Result<ClipFigures> clip_to_half_spaces(mesh::Mesh& mesh, std::span<const mesh::HalfSpace> kept,
                                                      const ClipOptions& options, const Context& context);

}  // namespace isoextract::edit
