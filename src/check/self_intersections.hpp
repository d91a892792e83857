// Where a mesh passes through itself: every two triangles that have a point in common which is no corner or side that
// they share. Exact (mesh/exact_sign), for all finite float32 coordinates.
//
// Triangles are taken with their border: those that touch meet. What two share is told by coordinates, not by indices,
// so that seams of doubled vertices are no intersections. Triangles without area are left out, and so is a pair with
// the same three corners: both are told for themselves.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::check {

struct IntersectionOptions {
  // The search ends when more pairs than this were found: all copies of one soup could take years.
  std::uint64_t most_pairs = 10'000'000;
  std::size_t examples = 5;
};

struct SelfIntersections {
  std::uint64_t pairs = 0;         // of triangles; a triangle that is there n times has n times as many
  bool at_least = false;           // there are more than `pairs`, which is IntersectionOptions::most_pairs
  std::uint64_t in_one_plane = 0;  // of the pairs: both lie in one plane and overlap
  std::uint64_t neighbours = 0;    // of the pairs: they share a corner or a side, and more
  std::uint64_t triangles = 0;     // how many triangles are in the pairs, copies once
  // The first pairs, by their first and then by their second triangle; the first of them comes first.
  std::vector<std::array<std::uint32_t, 2>> examples;

  std::uint64_t looked_at = 0;            // pairs that boxes did not tell apart: what the search costs
  std::uint64_t zero_area_triangles = 0;  // their corners are on one line, exactly
  std::uint64_t duplicate_triangles = 0;  // with the corners of an earlier one, whichever way they wind
};

// Where there are more pairs than may be, in_one_plane, neighbours and triangles are 0: nobody counted them. The same
// for any number of threads. Positions are finite. Fails with ErrorCode::input where there is no memory for it,
// and with ErrorCode::cancelled.
[[nodiscard]] Result<SelfIntersections> find_self_intersections(const mesh::Mesh& mesh,
                                                                const IntersectionOptions& options,
                                                                const Context& context);

}  // namespace isoextract::check
