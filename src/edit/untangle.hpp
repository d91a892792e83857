// Removes self-intersections of a mesh, so that it becomes printable.
//
// Marching cubes joins the two loops of a tunnel through a cell by flat triangles, which can intersect. In each round,
// untangle() flips edges of intersecting triangles where a flip leaves fewer intersecting pairs
// (detail/edge_flips.hpp). In a round without such a flip, it moves single vertices to places with fewer pairs. In a
// round without such a move, it splits edges by new vertices at such places (detail/place_search.hpp): a tunnel with
// three edges around it may have too few vertices for any place to help. Each change leaves fewer pairs. No vertex
// moves farther than a voxel in total. Vertices of more than 64 triangles do not move.
//
// Vertices of boundary edges and of cuts stay in place; vertices of caps move only in the plane of their cap. Flips
// keep the outline of a cap: its triangles change only for other triangles of the cap.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "edit/smooth.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct UntangleOptions {
  std::optional<DataBox> walls;           // SmoothOptions::walls
  std::span<const mesh::HalfSpace> cuts;  // SmoothOptions::cuts
  glm::dmat3 to_metric{1.0};  // maps the mesh's coordinates to the space in which moves are measured: usually voxels
};

struct UntangleFigures {
  std::uint64_t pairs_before = 0;  // intersecting pairs of triangles (mesh/self_intersections.hpp), counted up to 2^20
  std::uint64_t pairs_after = 0;   // counted up to 2^20
  bool more_before = false;        // there were more pairs than pairs_before, which is the limit of the search
  std::uint64_t flips = 0;         // flipped edges
  std::uint64_t splits = 0;        // edges split by a new vertex
  std::uint64_t moved = 0;         // moved vertices
  double greatest_move = 0;        // in the space of UntangleOptions::to_metric
  // Upper bound of the Hausdorff distance between the surface before and after, in the space of
  // UntangleOptions::to_metric
  double distance = 0;
  int rounds = 0;
  StageTime time;
};

// Changes the mesh until no triangles intersect or no change leaves fewer pairs, but for at most 160 rounds. While more
// than 2,000 pairs are left, only flips edges. While more than 100 are left, stops if a round of moves or splits, with
// the flips after it, removes less than a tenth of the pairs. Leaves a mesh without intersections unchanged. Otherwise
// keeps the order of the vertices, their attributes and their old normals, and drops edge keys. New vertices and
// triangles follow the old ones; a new vertex has the normal and attributes of the middle of its edge
// (mesh::set_interpolated()). A closed manifold stays one, with the same genus. Positions must be finite. The result
// does not depend on the number of threads. Fails with ErrorCode::out_of_memory or ErrorCode::cancelled.
[[nodiscard]] Result<UntangleFigures> untangle(mesh::Mesh& mesh, const UntangleOptions& options,
                                               const Context& context);

}  // namespace isoextract::edit
