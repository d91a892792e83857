// Normals for smooth shading of meshes whose files have none.
#pragma once

#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::render {

// Gives a mesh without normals those of its vertices: the sum over the triangles around of their planes' normals,
// weighted by the angle at the vertex (Thuermer and Wuethrich, "Computing vertex normals from polygonal facets", 1998).
// A vertex without a triangle, or whose triangles cancel out, has (0, 0, 1). One that has normals is left alone. Fails
// with ErrorCode::input where the memory is not there; `source` starts the message.
[[nodiscard]] Result<void> add_normals(mesh::Mesh& mesh, const std::string& source, const Context& context);

}  // namespace isoextract::render
