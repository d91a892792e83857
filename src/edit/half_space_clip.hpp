// Triangles cut at planes: of a mesh what lies in half-spaces is kept, exactly. This is the clipping of polygons by
// Sutherland and Hodgman (Reentrant polygon clipping, Comm. ACM 17(1), 1974), triangle by triangle; triangles that
// share an edge share the vertex that it is cut at.
#pragma once

#include <cstdint>
#include <span>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// What becomes of the surface where a plane cuts it.
enum class CutEnds {
  open,
  capped  // closed by triangles in the plane
};

struct ClipFacts {
  std::uint64_t triangles_before = 0;
  std::uint64_t triangles_cut = 0;  // that a plane goes through
  std::uint64_t triangles_after = 0;
  std::uint64_t cap_triangles = 0;  // of all caps, before later planes cut them
  std::uint64_t caps_overlap =
      0;  // of them, that overlap others by more than rounding: there the surface passes through itself
};

// Keeps of `mesh`, which has no attributes yet, what lies in all of `kept`, given in its own coordinates. Vertices that
// are nearer to a plane than a few roundings of a float32 position count as on it and stay where they are; all that is
// left is within that of the half-spaces. Old vertices stay in their order, new ones follow; triangles stay in their
// order and wind as before, and normals of new vertices are those between. Nothing changes where nothing is
// outside. An edge that two meshes share, or that is cut for both sides of a plane, is cut at the same place, bit for
// bit. The same for any number of threads. Memory is reserved; fails where it is not there.
//
// The mesh is open where it was cut, or capped: then what each plane opens is closed by flat triangles behind all
// others, which face out of the half-space, before the next plane cuts; triangles in a plane whose outside is on its
// kept side, on which there is nothing left to bound, go. The edges of a cap's loops are those of the cut, and it has
// their vertices: what was closed, oriented and a manifold is so afterwards, and has lost the volume outside. A cut
// that ends at a border of the surface is refused, with ErrorCode::input.
[[nodiscard]] Result<ClipFacts> clip_to_half_spaces(mesh::Mesh& mesh, std::span<const mesh::HalfSpace> kept,
                                                    CutEnds ends, const Context& context);

}  // namespace isoextract::edit
