// Finds where a mesh intersects itself: all pairs of triangles with a common point besides the corners and the edge
// that they share. Exact for all finite float32 coordinates (mesh/exact_sign.hpp).
//
// A triangle includes its edges and corners, so triangles that touch intersect. Shared corners are found by
// coordinates, not by indices, so seams of duplicated vertices do not count. Skips zero-area triangles and pairs with
// the same three corners; both have counts of their own.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

struct IntersectionOptions {
  // The search stops when it has found more pairs than this: many overlapping copies of a mesh could take years.
  std::uint64_t most_pairs = 10'000'000;
  std::size_t examples = 5;
};

struct SelfIntersections {
  std::uint64_t pairs = 0;         // pairs of triangles; a triangle with n copies counts n times
  bool at_least = false;           // there are more than `pairs`, which is then IntersectionOptions::most_pairs
  std::uint64_t in_one_plane = 0;  // pairs that overlap in one plane
  std::uint64_t neighbors = 0;     // pairs that share a corner or an edge and also touch elsewhere
  std::uint64_t triangles = 0;     // triangles in these pairs, copies counted once
  // The first pairs, ordered by first and then by second triangle; the lower number comes first.
  std::vector<std::array<std::uint32_t, 2>> examples;

  std::uint64_t looked_at = 0;            // pairs that the search tested exactly: their bounding boxes overlap
  std::uint64_t zero_area_triangles = 0;  // corners exactly on one line
  std::uint64_t duplicate_triangles = 0;  // with the corners of an earlier triangle, in either winding
};

// Finds the self-intersections of a mesh with finite positions. If at_least is set, in_one_plane, neighbors, triangles
// and looked_at are 0. The result does not depend on the number of threads. Fails with ErrorCode::out_of_memory if
// memory is short, or with ErrorCode::cancelled.
[[nodiscard]] Result<SelfIntersections> find_self_intersections(const Mesh& mesh, const IntersectionOptions& options,
                                                                const Context& context);

}  // namespace isoextract::mesh
