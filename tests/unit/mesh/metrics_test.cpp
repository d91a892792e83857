#include "mesh/metrics.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "unit/mesh/shapes.hpp"

namespace isoextract::mesh {
namespace {

TEST(Metrics, MeasuresTetrahedron) {
  Mesh mesh = test::unit_tetrahedron();
  mesh.origin = {1e7, 0, -5};
  const MeshSize size = measure_size(mesh);
  EXPECT_NEAR(size.volume, 1.0 / 6, 1e-15);
  EXPECT_NEAR(size.area, 1.5 + std::sqrt(3.0) / 2, 1e-15);
  EXPECT_EQ(size.zero_area_triangles, 0U);
  const Bounds bounds = measure_bounds(mesh);
  EXPECT_EQ(bounds.min, glm::dvec3(1e7, 0, -5));
  EXPECT_EQ(bounds.max, glm::dvec3(1e7 + 1, 1, -4));
  EXPECT_EQ(measure_local_bounds(mesh).max, glm::vec3(1));
}

TEST(Metrics, InvertedMeshHasNegativeVolume) {
  Mesh mesh = test::unit_tetrahedron();
  for (glm::uvec3& t : mesh.triangles) std::swap(t.x, t.y);
  EXPECT_NEAR(measure_size(mesh).volume, -1.0 / 6, 1e-15);
}

TEST(Metrics, CountsZeroAreaTriangles) {
  const Mesh mesh = test::make_mesh({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {0, 1, 0}}, {{0, 1, 2}, {0, 1, 3}, {3, 3, 0}});
  EXPECT_EQ(measure_size(mesh).zero_area_triangles, 2U);
}

TEST(Metrics, EmptyMeshHasZeroSize) {
  EXPECT_EQ(measure_size(Mesh{}).area, 0);
  EXPECT_EQ(measure_bounds(Mesh{}).max, glm::dvec3(0));
}

}  // namespace
}  // namespace isoextract::mesh
