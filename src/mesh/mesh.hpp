// An indexed triangle mesh as a structure of arrays.
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

// The grid edge that a vertex lies on: its lower sample, in indices of the whole field, and its direction. The
// direction has a bit for each axis that the edge runs along (1 is x, 2 is y, 4 is z). Direction 0 marks a cap
// vertex, which lies at sample `low`.
struct EdgeKey {
  glm::ivec3 low{0};
  std::int32_t direction = 0;

  friend bool operator==(const EdgeKey&, const EdgeKey&) = default;
  // Compares samples in the order of dense memory, x fastest.
  friend bool operator<(const EdgeKey& a, const EdgeKey& b) {
    return std::tie(a.low.z, a.low.y, a.low.x, a.direction) < std::tie(b.low.z, b.low.y, b.low.x, b.direction);
  }
};

// The appearance of a surface, for formats with materials.
struct Material {
  std::optional<glm::dvec3> color;  // linear light, each channel from 0 to 1; empty: the writer's default
  double opacity = 1;               // above 0, at most 1
  bool double_sided = false;        // no back-face culling; set for open surfaces

  friend bool operator==(const Material&, const Material&) = default;
};

// Triangles wind counter-clockwise seen from outside. The extractors weld vertices by integer keys. Method::mc and
// Method::mt make one vertex per crossed grid edge; NaN holes and shading normals can duplicate it. A position is
// origin + positions[v]: float32 relative to an origin in double, which keeps the accuracy far from the world's origin.
// The origin is exactly 0 if float32 world coordinates are accurate enough.
struct Mesh {
  std::string name;  // for formats that store names
  glm::dvec3 origin{0.0};
  Buffer<glm::vec3> positions;
  Buffer<glm::vec3> normals;     // unit length, outward, one per vertex; or empty
  Buffer<EdgeKey> edges;         // one per vertex if requested; or empty
  Buffer<glm::uvec3> triangles;  // vertex indices
  std::vector<Attribute> attributes;
  std::optional<Material> material;  // empty: the writer's default
  Reservation memory;                // for all arrays; the code that allocated them reserved it; may be empty

  [[nodiscard]] glm::dvec3 position(std::size_t vertex) const { return origin + glm::dvec3(positions[vertex]); }
};

}  // namespace isoextract::mesh
