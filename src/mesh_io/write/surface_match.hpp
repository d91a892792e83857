// Tells whether two surfaces are equal except for the order of vertices and triangles, and which vertices correspond.
//
// Each vertex starts with a color, a 64-bit hash of its own data. In a few rounds it mixes in the colors of its
// neighbors, in the order of the triangles' corners (color refinement; Weisfeiler and Leman, 1968).
// Vertices with the same color then have the same surroundings. Different surfaces pass as equal only if these rounds
// cannot tell them apart, or by a collision of hashes, whose probability is about 2^-64.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::mesh_io {

// Corresponding vertices of two surfaces. Vertices of the same color are interchangeable: only their numbers differ.
struct VertexMatch {
  struct Vertex {
    std::uint64_t color;
    std::uint32_t number;
  };
  std::vector<Vertex> a;  // sorted by color
  std::vector<Vertex> b;  // the same colors in the same order

  // Returns the end of the group of vertices that have the color of entry `first`, which begins that group.
  [[nodiscard]] std::size_t end_of_group(std::size_t first) const;
};

struct ColoredSurface {
  std::vector<std::uint64_t> colors;  // one per vertex
  std::span<const glm::uvec3> triangles;
};

// Returns nullopt if the surfaces differ; a flipped triangle counts as a difference. Needs about 40 bytes per vertex of
// each surface.
[[nodiscard]] std::optional<VertexMatch> match_colored_vertices(ColoredSurface a, ColoredSurface b);

}  // namespace isoextract::mesh_io
