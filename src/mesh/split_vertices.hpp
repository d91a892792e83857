// Splits vertices where several fans of triangles meet.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

// After triangles were removed, a vertex may be unused, or several fans of triangles may meet at it. Removes unused
// vertices and gives each further fan a copy of its vertex. The mesh then is a manifold with boundary, if no edge has
// more than two triangles.
//
// Vertices keep their order. Copies follow their original in the order of the fans' first triangles, with all its
// attributes. Fails with ErrorCode::out_of_memory, and with ErrorCode::input if there are more vertices than a mesh can
// number; `source` starts the message.
[[nodiscard]] Result<void> split_nonmanifold_vertices(Mesh& mesh, const std::string& source, const Context& context);

}  // namespace isoextract::mesh
