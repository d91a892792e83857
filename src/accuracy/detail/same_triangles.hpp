// Finds the triangles that two meshes have in common, by position.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/mesh.hpp"

namespace isoextract::accuracy {

// Returns for each triangle of `a`, moved by `shift`, 1 if `b` has a triangle with exactly the same corners in any
// order and winding, else 0. Such a triangle is at distance 0 from `b`, whatever rounding says. Positions must be
// finite. Does not depend on the number of threads.
[[nodiscard]] std::vector<char> mark_common_triangles(const mesh::Mesh& a, const mesh::Mesh& b,
                                                      const glm::dvec3& shift);

// Returns the memory that mark_common_triangles() uses.
[[nodiscard]] std::uint64_t common_triangles_bytes(const mesh::Mesh& a, const mesh::Mesh& b);

}  // namespace isoextract::accuracy
