// Checks the normals of a file against its triangles.
#pragma once

#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "mesh/mesh.hpp"

namespace isoextract::check {

struct NormalFigures {
  std::uint64_t corners = 0;   // corners with a normal, of triangles with area
  std::uint64_t against = 0;   // of `corners`: the normal is more than 90 degrees off the triangle's normal
  std::uint64_t missing = 0;   // corners of triangles with area whose normal is absent, zero or NaN
  std::uint64_t not_unit = 0;  // of `corners`: the length differs from 1 by more than 0.01

  [[nodiscard]] double flipped_fraction() const {
    return corners == 0 ? 0 : static_cast<double>(against) / static_cast<double>(corners);
  }
};

constexpr std::uint32_t kNoNormal = ~std::uint32_t{0};

// Checks the corners of all triangles with area. `numbers` has an entry for each triangle: for each corner the index in
// `normals`, or kNoNormal.
[[nodiscard]] NormalFigures check_normals(const mesh::Mesh& mesh, std::span<const glm::vec3> normals,
                                          std::span<const glm::uvec3> numbers);

}  // namespace isoextract::check
