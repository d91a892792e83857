// The triangles that two meshes have in common, by places.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/mesh.hpp"

namespace isoextract::accuracy {

// One entry a triangle of `a`, moved by `shift`: 1 where `b` has a triangle with the very same corners, in any order
// and with any winding; else 0. No point of such a triangle is away from `b`, and no rounding of distances says
// otherwise. Positions are finite. The same for any number of threads.
[[nodiscard]] std::vector<char> triangles_in_both(const mesh::Mesh& a, const mesh::Mesh& b, const glm::dvec3& shift);

// What that takes in memory.
[[nodiscard]] std::uint64_t triangles_in_both_bytes(const mesh::Mesh& a, const mesh::Mesh& b);

}  // namespace isoextract::accuracy
