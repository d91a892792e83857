// Gives the triangles of a mesh one winding, and closed components the side that bounds bodies.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "edit/detail/edge_uses.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct OrientFigures {
  std::uint64_t turned = 0;          // triangles
  std::uint64_t contradictions = 0;  // edges that no winding satisfies
};

// Turns triangles so that neighbors across edges of two triangles agree. In each patch that such edges connect, the
// majority keeps its winding; of equal parts that of the first triangle. `uses` are those of the mesh. Throws
// std::bad_alloc.
[[nodiscard]] OrientFigures orient_patches(mesh::Mesh& mesh, const EdgeUses& uses);

// Turns closed components that face outward inside an odd number of others, or inward inside an even number, and
// returns their number. Fails with ErrorCode::out_of_memory or cancelled. Throws std::bad_alloc.
[[nodiscard]] Result<std::uint64_t> face_by_nesting(mesh::Mesh& mesh, const Context& context);

}  // namespace isoextract::edit
