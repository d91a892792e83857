// One vertex for every fan of triangles.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

// Where triangles were left out, a vertex may have none any more, or several fans of triangles that meet in it alone.
// This drops the former, and gives each further fan a copy of its vertex: then the mesh is a manifold with a border,
// if no edge has more than two triangles. Vertices keep their order; copies stand behind the vertex they copy, in the
// order of their fans' first triangles, and have all that belongs to it. Fails with ErrorCode::input where that
// needs more memory than is left, or more vertices than a mesh can number; `source` starts the message.
[[nodiscard]] Result<void> make_one_vertex_a_fan(Mesh& mesh, const std::string& source, const Context& context);

}  // namespace isoextract::mesh
