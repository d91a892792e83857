// Vertices and triangles in an order in which graphics cards and packers find what they need near by.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh_io {

// The same mesh, its triangles so that their corners are met again soon (T. Forsyth, Linear-Speed Vertex Cache
// Optimisation, 2006, as meshoptimizer has it), its vertices in the order in which triangles want them. The same for
// the same mesh. Fails where the memory is not there.
[[nodiscard]] Result<void> optimize_order(mesh::Mesh& mesh, const Context& context);

}  // namespace isoextract::mesh_io
