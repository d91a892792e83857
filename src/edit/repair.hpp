// Repairs a mesh, so that it bounds bodies: welds, drops, orients and fills, in this order.
//
// 1. Weld: vertices at equal positions become one if they lie on boundary edges or if an edge of length 0 joins them.
//    Sheets that touch without a boundary stay apart.
// 2. Drop: triangles without area and triangles with the corners of an earlier one. A triangle whose corners lie on one
//    line gives its middle corner to the neighbor at its longest edge, so that no hole opens.
// 3. Orient: neighbors across edges of two triangles get one winding, that of the majority in each connected patch.
// 4. Fill: each boundary loop of up to `most_hole_edges` edges gets triangles of small area (P. Liepa, Filling holes in
//    meshes, SGP 2003, without its refinement). A loop whose triangles would have 3/4 of the area of its component or
//    more stays: it is the rim of a sheet.
// 5. Face outward: closed components face outward inside an even number of others, and inward inside an odd number
//    (mesh/shells.hpp).
// Last, vertices where sheets touch are split, and unused vertices are removed.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

inline constexpr std::uint64_t kUsualHoleEdges = 100;
inline constexpr std::uint64_t kMostHoleEdges = 1000;  // filling takes time with the cube of the edges

struct RepairOptions {
  std::uint64_t most_hole_edges = kUsualHoleEdges;  // up to kMostHoleEdges; 0 fills nothing
};

struct RepairFigures {
  std::uint64_t welded = 0;          // vertices that became another one
  std::uint64_t without_area = 0;    // triangles that were dropped or got area
  std::uint64_t duplicates = 0;      // triangles that were dropped
  std::uint64_t turned = 0;          // triangles turned to agree with their patch
  std::uint64_t contradictions = 0;  // edges of one-sided patches, such as a Moebius strip, which stay
  std::uint64_t holes_filled = 0;
  std::uint64_t fill_triangles = 0;
  std::uint64_t holes_left = 0;
  std::uint64_t holes_too_long = 0;  // of those left; the others are as large as their component
  std::uint64_t components_turned = 0;  // closed components whose side did not fit their nesting
  StageTime time;
};

// Repairs the mesh. Adds no vertices but copies of those where sheets touch; attributes stay with their vertices.
// Removes normals and edge keys. The result does not depend on the number of threads. Positions must be finite and
// indices valid. Fails with ErrorCode::out_of_memory or cancelled.
[[nodiscard]] Result<RepairFigures> repair(mesh::Mesh& mesh, const RepairOptions& options, const Context& context);

}  // namespace isoextract::edit
