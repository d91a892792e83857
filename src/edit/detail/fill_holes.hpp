// Fills the holes of a mesh with triangles between the vertices of their boundary loops.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "edit/detail/edge_uses.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct FillFigures {
  std::uint64_t filled = 0;     // loops that got triangles
  std::uint64_t triangles = 0;  // added triangles
  std::uint64_t left = 0;       // loops that stay open
  std::uint64_t too_long = 0;   // loops that stay open because they have more than `most_edges` edges
};

// Fills each boundary loop of up to `most_edges` edges. A loop stays open if its triangles would have 3/4 of the area
// of its component or more. A loop that meets a vertex twice counts as several loops.
//
// Chooses among all triangulations of a loop, by these criteria in this order:
//   - the smallest sum of two counts: triangles without area, and edges that the mesh has already;
//   - the least area; short new edges decide between nearly equal areas.
//
// `uses` lists the edges of `mesh`. Neighboring triangles must have the same winding: fills only loops that all
// boundary edges run around in one direction, and counts only these. The time grows with the cube of the edges of a
// loop. Fails with ErrorCode::out_of_memory or ErrorCode::cancelled. Throws std::bad_alloc.
[[nodiscard]] Result<FillFigures> fill_holes(mesh::Mesh& mesh, const EdgeUses& uses, std::uint64_t most_edges,
                                             const Context& context);

}  // namespace isoextract::edit
