#include "check/normal_check.hpp"

#include <cmath>

#include "base/reduction.hpp"

namespace isoextract::check {
namespace {

struct NormalSums : NormalFigures {
  void merge(const NormalSums& other) {
    corners += other.corners;
    against += other.against;
    missing += other.missing;
    not_unit += other.not_unit;
  }
};

}  // namespace

NormalFigures check_normals(const mesh::Mesh& mesh, std::span<const glm::vec3> normals,
                            std::span<const glm::uvec3> numbers) {
  return reduce_in_order(mesh.triangles.size(), NormalSums(), nullptr, [&](const PointRange& range, NormalSums& sums) {
    for (std::size_t t = range.begin(); t != range.end(); ++t) {
      const glm::uvec3& triangle = mesh.triangles[t];
      const glm::dvec3 a(mesh.positions[triangle.x]);
      const glm::dvec3 face =
          glm::cross(glm::dvec3(mesh.positions[triangle.y]) - a, glm::dvec3(mesh.positions[triangle.z]) - a);
      if (face == glm::dvec3(0)) continue;
      for (int c = 0; c < 3; ++c) {
        const std::uint32_t number = numbers[t][c];
        const glm::dvec3 normal(number == kNoNormal ? glm::vec3(0) : normals[number]);
        const double length = glm::length(normal);
        if (!(length > 0)) {
          ++sums.missing;
          continue;
        }
        constexpr double kTolerance = 0.01;
        ++sums.corners;
        sums.not_unit += std::abs(length - 1) <= kTolerance ? 0 : 1;
        sums.against += glm::dot(normal, face) < 0 ? 1 : 0;
      }
    }
  });
}

}  // namespace isoextract::check
