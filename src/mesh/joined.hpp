// Several meshes as one.
#pragma once

#include <span>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

// Positions and triangles of all, one mesh after the other; nothing else of them. Their origins are the same, but for
// those of meshes without vertices. Fails with ErrorCode::input where there is no memory for it, and for more vertices
// than 32-bit numbers count.
[[nodiscard]] Result<Mesh> join_meshes(std::span<const Mesh> meshes, const Context& context);

}  // namespace isoextract::mesh
