// Whether two surfaces are one whose vertices and triangles come in another order, and which vertices are the same.
//
// Vertices start with a colour made of their own data, and take up those around them, as they follow each other in the
// triangles, in a few rounds (colour refinement; Weisfeiler and Leman, 1968). Vertices with the same colour then have
// the same surroundings. Colours are hashes of 64 bits: surfaces that differ pass with a probability of about 2^-64.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::mesh_io {

// A vertex stands in for those of its colour: where several have one, nothing but their numbers tells them apart.
struct SameVertices {
  struct Vertex {
    std::uint64_t colour;
    std::uint32_t number;
  };
  std::vector<Vertex> a;  // by colour
  std::vector<Vertex> b;  // the same colours at the same places

  // The end of the vertices with the colour of the one at `first`.
  [[nodiscard]] std::size_t end_of_group(std::size_t first) const;
};

struct ColouredSurface {
  std::vector<std::uint64_t> colours;  // one a vertex
  std::span<const glm::uvec3> triangles;
};

// Nothing where the surfaces are not the same, or triangles turned over. Takes some 40 bytes a vertex of each.
[[nodiscard]] std::optional<SameVertices> match_vertices(ColouredSurface a, ColouredSurface b);

}  // namespace isoextract::mesh_io
