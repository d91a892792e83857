// Moves the vertices of a mesh, and takes moves back where they make triangles intersect.
//
// The vertices of triangles that intersect, and did not before, move half as far, then a quarter, then not at all,
// until no such pair is left. A vertex that stays can make its triangles meet other triangles, whose vertices then move
// less, too. Tests are exact and count as mesh/self_intersections.hpp does.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct UntangledMoves {
  Buffer<glm::vec3> before;         // the positions before the moves
  std::uint64_t held_vertices = 0;  // vertices that moved less than they should
};

// Moves each vertex by its entry of `moves`, or by less where the move would make triangles intersect. The result does
// not depend on the number of threads. Fails with ErrorCode::out_of_memory or ErrorCode::cancelled; `mesh` may then be
// moved.
[[nodiscard]] Result<UntangledMoves> move_untangled(mesh::Mesh& mesh, const Buffer<glm::vec3>& moves,
                                                    const Context& context);

}  // namespace isoextract::edit
