// Repairs a mesh, so that it bounds bodies. The steps, in this order:
//
// 1. Weld: merges vertices at equal positions if they lie on boundary edges, or if an edge of length 0 joins them.
//    Sheets that touch away from boundary edges stay apart.
// 2. Drop: removes triangles without area, and triangles with the corners of an earlier one. If three distinct corners
//    lie on one line, the middle one splits the neighbor at the triangle's longest edge. The two halves replace both
//    triangles, so that no hole opens. A triangle without a suitable neighbor is dropped.
// 3. Orient: gives neighbors across edges of two triangles one winding, that of the majority in each connected patch.
// 4. Fill: fills each boundary loop of up to `most_hole_edges` edges with triangles of small area (P. Liepa, Filling
//    holes in meshes, SGP 2003, without its refinement). If these triangles would have 3/4 of the area of the component
//    or more, the loop stays open: it is the rim of a sheet.
// 5. Split: gives each sheet its own copy of a vertex where sheets touch, and removes unused vertices.
// 6. Face outward: a closed component faces outward inside an even number of other closed components, and inward inside
//    an odd number (mesh/shells.hpp).
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

inline constexpr std::uint64_t kUsualHoleEdges = 100;
inline constexpr std::uint64_t kMostHoleEdges = 1000;  // the time to fill a hole grows with the cube of its edges

struct RepairOptions {
  std::uint64_t most_hole_edges = kUsualHoleEdges;  // up to kMostHoleEdges; 0 fills nothing
};

struct RepairFigures {
  std::uint64_t welded = 0;          // vertices merged into another vertex
  std::uint64_t values_lost = 0;     // welded vertices whose attributes differed from those of the remaining vertex
  std::uint64_t without_area = 0;    // triangles without area, dropped or given area
  std::uint64_t duplicates = 0;      // dropped duplicate triangles
  std::uint64_t turned = 0;          // triangles with flipped winding in step 3
  std::uint64_t contradictions = 0;  // edges between triangles of opposite winding that stay: in a Moebius strip
  std::uint64_t holes_filled = 0;
  std::uint64_t fill_triangles = 0;
  std::uint64_t holes_left = 0;         // loops that stay open: holes_too_long, and the rims of sheets
  std::uint64_t holes_too_long = 0;     // loops of more than `most_hole_edges` edges
  std::uint64_t vertices_split = 0;     // copies of vertices in step 5
  std::uint64_t unused_removed = 0;     // vertices that had no triangle at the start
  std::uint64_t components_turned = 0;  // closed components with flipped winding in step 6
  StageTime time;
};

// Repairs the mesh. The only new vertices are the copies of step 5. Vertices keep their positions and attributes;
// a vertex that others merge into keeps its own. Removes normals and edge keys. The result does not depend on the
// number of threads. Positions must be finite and indices valid. Fails with ErrorCode::out_of_memory or
// ErrorCode::cancelled; the mesh may then be half repaired.
[[nodiscard]] Result<RepairFigures> repair(mesh::Mesh& mesh, const RepairOptions& options, const Context& context);

}  // namespace isoextract::edit
