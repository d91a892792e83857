// Gives neighboring triangles of a mesh the same winding, and faces closed shells outward and cavities inward.
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

// Turns triangles so that neighbors agree across each edge with exactly two triangles. In each patch that such edges
// connect, the majority keeps its winding; with equal numbers, the first triangle keeps its own. `uses` lists the edges
// of the mesh. Throws std::bad_alloc.
[[nodiscard]] OrientFigures orient_patches(mesh::Mesh& mesh, const EdgeUses& uses);

// Makes a closed component face inward if it lies inside an odd number of other closed components, else outward.
// Returns the number of components turned. Fails with ErrorCode::out_of_memory or cancelled. Throws std::bad_alloc.
[[nodiscard]] Result<std::uint64_t> face_by_nesting(mesh::Mesh& mesh, const Context& context);

}  // namespace isoextract::edit
