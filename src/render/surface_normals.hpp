// Computes vertex normals for smooth shading of meshes without normals.
#pragma once

#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::render {

// Adds unit vertex normals to a mesh without normals. Each is the normalized sum of the unit normals of the adjacent
// triangles, weighted by the angle at the vertex (Thuermer and Wuethrich, "Computing vertex normals from polygonal
// facets", 1998). A vertex without triangles, or whose sum is zero, gets (0, 0, 1).
// Does nothing if the mesh has normals. Fails with ErrorCode::out_of_memory if memory is short; `source` starts the
// message.
[[nodiscard]] Result<void> add_normals(mesh::Mesh& mesh, const std::string& source, const Context& context);

}  // namespace isoextract::render
