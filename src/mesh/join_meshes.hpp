// Joins several meshes into one.
#pragma once

#include <span>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

// Returns the positions and triangles of all meshes, one after the other, without normals and attributes. All meshes
// with vertices must have the same origin. Fails with ErrorCode::out_of_memory, and with ErrorCode::input if the number
// of vertices exceeds 32 bits.
[[nodiscard]] Result<Mesh> join_meshes(std::span<const Mesh> meshes, const Context& context);

}  // namespace isoextract::mesh
