// Joins several meshes into one.
#pragma once

#include <span>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

// Returns a mesh of the positions and triangles of all meshes, one after the other, without name, normals, edge keys,
// attributes and material. All meshes with vertices must have the same origin. Fails with ErrorCode::out_of_memory, and
// with ErrorCode::input if there are more vertices than 32-bit indices allow. Throws std::bad_alloc.
[[nodiscard]] Result<Mesh> join_meshes(std::span<const Mesh> meshes, const Context& context);

}  // namespace isoextract::mesh
