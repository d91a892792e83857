// Fills the holes of a mesh with triangles between the vertices of their rims.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "edit/detail/edge_uses.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct FillFigures {
  std::uint64_t filled = 0;     // loops
  std::uint64_t triangles = 0;  // added
  std::uint64_t left = 0;       // loops
  std::uint64_t too_long = 0;   // of those left
};

// Fills each boundary loop of up to `most_edges` edges whose triangles have less than 3/4 of the area of its component.
// A loop that meets a vertex twice counts as several loops. Of all triangulations of a loop, takes the one with the
// fewest triangles without area and edges that the mesh has already, then with the least area; short edges decide
// between nearly equal areas. The triangles must agree in their winding; `uses` are those of the mesh. Takes time with
// the cube of a loop's edges. Fails with ErrorCode::out_of_memory or cancelled. Throws std::bad_alloc.
[[nodiscard]] Result<FillFigures> fill_holes(mesh::Mesh& mesh, const EdgeUses& uses, std::uint64_t most_edges,
                                             const Context& context);

}  // namespace isoextract::edit
