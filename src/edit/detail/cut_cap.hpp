// The cap that closes a mesh where a plane cuts it.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct CutCapFigures {
  std::uint64_t triangles = 0;
  // Cap triangles that overlap other cap triangles by more than rounding because the cut crosses itself.
  std::uint64_t turned = 0;
};

// Fills the boundary loops in the plane of `kept` with triangles that face out of `kept`. A boundary edge counts if
// both its ends lie within `on_plane` of the plane. If loops meet at a vertex, calls split_nonmanifold_vertices() for
// the whole mesh first. Adds vertices only at midpoints of edges that would occur twice. New triangles come last.
// The mesh must have no edge keys.
//
// Fails with ErrorCode::input if the edges form no closed loops (the mesh was open before the cut), if a loop encloses
// no area, or if there are more vertices than 32-bit indices allow. Also fails with ErrorCode::out_of_memory and
// ErrorCode::cancelled.
[[nodiscard]] Result<CutCapFigures> cap_cut(mesh::Mesh& mesh, const mesh::HalfSpace& kept, double on_plane,
                                            const Context& context);

}  // namespace isoextract::edit
