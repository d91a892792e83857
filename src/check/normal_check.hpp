// The normals that a file has, against the triangles that they belong to.
#pragma once

#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "mesh/mesh.hpp"

namespace isoextract::check {

struct NormalFacts {
  std::uint64_t corners = 0;   // of triangles with area, that have a normal
  std::uint64_t against = 0;   // of them: the normal points to the other side of the triangle, more than 90 degrees off
  std::uint64_t missing = 0;   // corners of triangles with area that have none, or one of length 0 or that is no number
  std::uint64_t not_unit = 0;  // of `corners`: its length is not 1, to a hundredth

  [[nodiscard]] double fraction_against() const {
    return corners == 0 ? 0 : static_cast<double>(against) / static_cast<double>(corners);
  }
};

constexpr std::uint32_t kNoNormal = ~std::uint32_t{0};

// `numbers` say of each corner of each triangle which of `normals` it has, or kNoNormal.
[[nodiscard]] NormalFacts check_normals(const mesh::Mesh& mesh, std::span<const glm::vec3> normals,
                                        std::span<const glm::uvec3> numbers);

}  // namespace isoextract::check
