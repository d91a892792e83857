// Reorders vertices and triangles so that graphics cards and compressors find shared data close together.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh_io {

// Sorts the triangles for vertex reuse (the linear-speed method of T. Forsyth, 2006, as in meshoptimizer), and the
// vertices in the order of their first use. Deterministic. Fails as Context::reserve() does.
[[nodiscard]] Result<void> optimize_order(mesh::Mesh& mesh, const Context& context);

}  // namespace isoextract::mesh_io
