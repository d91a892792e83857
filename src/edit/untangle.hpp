// Makes a mesh printable whose triangles intersect in a few cells.
//
// Marching cubes joins the two loops of a tunnel through a cell by flat triangles, which can intersect. Edges are
// flipped where that leaves fewer pairs. If no flip does, vertices move toward the mean of their neighbors, by up to a
// voxel. No move makes other triangles intersect (detail/untangled_moves.hpp). Vertices of boundary edges stay, those
// of caps stay in their planes.
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
  std::optional<DataBox> walls;           // as in SmoothOptions
  std::span<const mesh::HalfSpace> cuts;  // as in SmoothOptions
  glm::dmat3 to_metric{1.0};              // maps the mesh's coordinates to the space of greatest_move
};

struct UntangleFigures {
  std::uint64_t pairs_before = 0;  // intersecting pairs of triangles (mesh/self_intersections.hpp)
  std::uint64_t pairs_after = 0;
  std::uint64_t flips = 0;  // of edges
  std::uint64_t moved = 0;  // vertices
  double greatest_move = 0;
  int rounds = 0;
  StageTime time;
};

// Flips and moves until no triangles intersect, or for a limited number of rounds. Keeps the order of vertices,
// attributes and normals; drops edge keys. Changes nothing without intersections. Positions must be finite. The result
// does not depend on the number of threads. Fails with ErrorCode::out_of_memory or ErrorCode::cancelled.
[[nodiscard]] Result<UntangleFigures> untangle(mesh::Mesh& mesh, const UntangleOptions& options,
                                               const Context& context);

}  // namespace isoextract::edit
