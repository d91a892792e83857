// The cap that closes a mesh where a plane has cut it.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct CutCap {
  std::uint64_t triangles = 0;
  std::uint64_t turned = 0;  // that overlap others by more than rounding, as the cut crosses itself
};

// Fills the loops of edges of `mesh` that have one triangle and lie with both ends within `on_plane` of the plane of
// `kept`, with triangles that face out of it. They have no new vertices but in the middle of edges that there would be
// twice; a vertex in which the loops meet is given a copy for each fan of triangles. New triangles come last. Fails
// with ErrorCode::input where such edges form no loops, as the mesh was open before it was cut, and where the memory is
// not there.
[[nodiscard]] Result<CutCap> close_cut(mesh::Mesh& mesh, const mesh::HalfSpace& kept, double on_plane,
                                       const Context& context);

}  // namespace isoextract::edit
