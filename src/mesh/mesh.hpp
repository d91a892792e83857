// An indexed triangle mesh, structure of arrays.
#pragma once

#include <cstdint>
#include <string>

#include <glm/glm.hpp>

#include "base/buffer.hpp"

namespace isoextract {

// Triangles wind counter-clockwise seen from outside. Vertices are welded: no two have the same grid edge.
// A position is origin + positions[v]: float32 relative to an origin in double, so that far-away frames keep their
// accuracy. The origin is exactly 0 where float32 world coordinates lose nothing that matters.
struct Mesh {
  std::string name;  // for the formats that have names
  glm::dvec3 origin{0.0};
  Buffer<glm::vec3> positions;
  Buffer<glm::vec3> normals;     // unit length, outward, one a vertex; or empty
  Buffer<glm::uvec3> triangles;  // vertex indices

  [[nodiscard]] glm::dvec3 position(std::size_t vertex) const { return origin + glm::dvec3(positions[vertex]); }
};

}  // namespace isoextract
