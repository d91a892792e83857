// An indexed triangle mesh, structure of arrays.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/memory_budget.hpp"
#include "mesh/attributes.hpp"

namespace isoextract::mesh {

// The edge of the grid that a vertex lies on: its lower sample, in indices of the whole field, and the axes that it
// runs along as bits (1 is x, 2 is y, 4 is z). Direction 0 is a vertex of a cap, at the sample itself.
struct EdgeKey {
  glm::ivec3 low{0};
  std::int32_t direction = 0;

  friend bool operator==(const EdgeKey&, const EdgeKey&) = default;
  // Samples in the order of dense memory, x fastest.
  friend bool operator<(const EdgeKey& a, const EdgeKey& b) {
    return std::tie(a.low.z, a.low.y, a.low.x, a.direction) < std::tie(b.low.z, b.low.y, b.low.x, b.direction);
  }
};

// How a surface looks, for formats that have materials.
struct Material {
  std::optional<glm::dvec3> colour;  // linear light, each channel from 0 to 1; nothing: the writer's own
  double opacity = 1;                // above 0, at most 1
  bool double_sided = false;         // seen from behind as well: of a surface that is open, whose inside shows

  friend bool operator==(const Material&, const Material&) = default;
};

// Triangles wind counter-clockwise seen from outside. Vertices are welded: no two have the same grid edge.
// A position is origin + positions[v]: float32 relative to an origin in double, so that far-away frames keep their
// accuracy. The origin is exactly 0 where float32 world coordinates lose nothing that matters.
struct Mesh {
  std::string name;  // for the formats that have names
  glm::dvec3 origin{0.0};
  Buffer<glm::vec3> positions;
  Buffer<glm::vec3> normals;     // unit length, outward, one a vertex; or empty
  Buffer<EdgeKey> edges;         // one a vertex, where they were asked for; or empty
  Buffer<glm::uvec3> triangles;  // vertex indices
  std::vector<Attribute> attributes;
  std::optional<Material> material;  // nothing: the writer's own
  Reservation memory;                // for all of this, by whoever allocated it; empty where nobody counts

  [[nodiscard]] glm::dvec3 position(std::size_t vertex) const { return origin + glm::dvec3(positions[vertex]); }
};

}  // namespace isoextract::mesh
