// Small voxel patterns, and the surfaces that they must have.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <tuple>
#include <vector>

#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::test {

struct VoxelPattern {
  glm::ivec3 dims{0};
  std::vector<std::uint8_t> inside;  // x fastest

  [[nodiscard]] bool at(const glm::ivec3& p) const {
    if (glm::any(glm::lessThan(p, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(p, dims))) return false;
    return inside[static_cast<std::size_t>(p.x + dims.x * (p.y + dims.y * p.z))] != 0;
  }
  [[nodiscard]] std::int64_t count() const { return std::count(inside.begin(), inside.end(), std::uint8_t{1}); }
  // Counts exposed faces by direction: -x, +x, -y, ...
  [[nodiscard]] std::array<std::int64_t, 6> exposed() const {
    std::array<std::int64_t, 6> faces{};
    for_each([&](const glm::ivec3& p) {
      if (!at(p)) return;
      for (int d = 0; d < 6; ++d) {
        glm::ivec3 step(0);
        step[d / 2] = d % 2 == 0 ? -1 : 1;
        if (!at(p + step)) ++faces[static_cast<std::size_t>(d)];
      }
    });
    return faces;
  }
  template <class F>
  void for_each(const F& f) const {
    for (int z = 0; z < dims.z; ++z) {
      for (int y = 0; y < dims.y; ++y) {
        for (int x = 0; x < dims.x; ++x) f(glm::ivec3(x, y, z));
      }
    }
  }
};

inline VoxelPattern random_pattern(const glm::ivec3& dims, unsigned seed, int percent) {
  std::mt19937 engine(seed);
  VoxelPattern pattern{dims, {}};
  pattern.for_each(
      [&](const glm::ivec3&) { pattern.inside.push_back(static_cast<int>(engine() % 100) < percent ? 1 : 0); });
  return pattern;
}

inline field::ScalarField field_of(const VoxelPattern& pattern) {
  return dense_field<std::uint8_t>(pattern.dims, [&](int x, int y, int z) { return pattern.at({x, y, z}) ? 1 : 0; });
}

inline extract::ExtractOptions voxel_options(extract::VoxelFaces faces = extract::VoxelFaces::merged) {
  extract::ExtractOptions options;
  options.method = extract::Method::voxels;
  options.voxel_faces = faces;
  options.iso = 0.5;
  return options;
}

// Returns the triangle area by direction, for a mesh in index space. Exact, since all numbers are small multiples of
// 1/2.
inline std::array<double, 6> areas_by_direction(const mesh::Mesh& mesh) {
  std::array<double, 6> areas{};
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = mesh.position(t.x);
    const glm::dvec3 normal = glm::cross(mesh.position(t.y) - a, mesh.position(t.z) - a) / 2.0;
    int axis = 0;
    while (axis < 2 && normal[axis] == 0) ++axis;
    glm::dvec3 rest = normal;
    rest[axis] = 0;
    EXPECT_EQ(rest, glm::dvec3(0)) << "a triangle across no axis";
    areas[static_cast<std::size_t>(2 * axis + (normal[axis] > 0 ? 1 : 0))] += std::abs(normal[axis]);
  }
  return areas;
}

// Returns the enclosed volume of a mesh in index space. Exact, since 48 times the volume is a sum of small integers.
inline double exact_volume(const mesh::Mesh& mesh) {
  double six_volumes = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    six_volumes += glm::dot(mesh.position(t.x), glm::cross(mesh.position(t.y), mesh.position(t.z)));
  }
  return six_volumes / 6;
}

// Expects the mesh to be closed, oriented and 2-manifold, with the voxels' volume and the area of their exposed faces
// in each direction.
inline void expect_surface_of(const VoxelPattern& pattern, const mesh::Mesh& mesh) {
  expect_sound(mesh, true);
  EXPECT_EQ(exact_volume(mesh), static_cast<double>(pattern.count()));
  const std::array<double, 6> areas = areas_by_direction(mesh);
  const std::array<std::int64_t, 6> faces = pattern.exposed();
  for (std::size_t d = 0; d < 6; ++d) EXPECT_EQ(areas[d], static_cast<double>(faces[d])) << "direction " << d;
}

}  // namespace isoextract::test
