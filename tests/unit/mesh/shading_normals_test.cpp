#include "mesh/shading_normals.hpp"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "mesh/topology.hpp"
#include "support/box_mesh.hpp"
#include "unit/mesh/shapes.hpp"

namespace isoextract::mesh {
namespace {

// A cube whose normals point away from its center, like a gradient at the corners.
Mesh cube() {
  Mesh mesh = test::box_mesh(glm::vec3(0), glm::vec3(1));
  mesh.normals = Buffer<glm::vec3>(8);
  for (std::size_t v = 0; v < 8; ++v) mesh.normals[v] = glm::normalize(mesh.positions[v] - 0.5F);
  return mesh;
}

glm::vec3 face_normal(const Mesh& mesh, const glm::uvec3& t) {
  return glm::normalize(
      glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
}

// A height field so rough that many gradients would point against triangles. All its normals point up.
Mesh rough(std::uint32_t side, unsigned seed) {
  std::mt19937 engine(seed);
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      const auto shift = [&] { return static_cast<float>(engine() % 1000) / 600.0F; };
      positions.emplace_back(static_cast<float>(x) + shift(), static_cast<float>(y) + shift(), 3 * shift());
    }
  }
  for (std::uint32_t y = 0; y + 1 < side; ++y) {
    for (std::uint32_t x = 0; x + 1 < side; ++x) {
      const std::uint32_t v = x + side * y;
      triangles.emplace_back(v, v + 1, v + side);
      triangles.emplace_back(v + 1, v + side + 1, v + side);
    }
  }
  Mesh mesh = test::make_mesh(positions, triangles);
  mesh.normals = Buffer<glm::vec3>(positions.size());
  std::ranges::fill(mesh.normals.span(), glm::vec3(0, 0, 1));
  return mesh;
}

TEST(ShadingNormals, CubeFacesAreFlat) {
  Mesh mesh = cube();
  const auto copies = compute_shading_normals(mesh, {.planes = {}, .crease_degrees = 30}, "cube", Context());
  ASSERT_TRUE(copies);
  EXPECT_EQ(*copies, 16U);
  ASSERT_EQ(mesh.positions.size(), 24U);
  ASSERT_EQ(mesh.normals.size(), 24U);
  for (const glm::uvec3& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) EXPECT_EQ(mesh.normals[t[c]], face_normal(mesh, t));
  }
  // The positions are the same; copies follow all original vertices.
  const Mesh before = cube();
  for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(mesh.positions[v], before.positions[v]);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(mesh.positions[mesh.triangles[t][c]], before.positions[before.triangles[t][c]]);
    }
  }
}

TEST(ShadingNormals, TreatPlanesAsCreasesAndKeepOtherNormals) {
  Mesh mesh = cube();
  const std::array<std::uint8_t, 12> planes{1, 1};  // the bottom, like a cap
  const auto copies = compute_shading_normals(mesh, {.planes = planes, .crease_degrees = {}}, "cube", Context());
  ASSERT_TRUE(copies);
  EXPECT_EQ(*copies, 4U);
  for (std::size_t t = 0; t < 12; ++t) {
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t v = mesh.triangles[t][c];
      const glm::vec3 gradient = glm::normalize(mesh.positions[v] - 0.5F);
      EXPECT_EQ(mesh.normals[v], t < 2 ? glm::vec3(0, 0, -1) : gradient) << t;
    }
  }
}

TEST(ShadingNormals, CopyNoVertexIfForbidden) {
  Mesh mesh = cube();
  mesh.normals = {};
  const auto copies =
      compute_shading_normals(mesh, {.planes = {}, .crease_degrees = {}, .may_copy = false}, "cube", Context());
  ASSERT_TRUE(copies);
  EXPECT_EQ(*copies, 0U);
  ASSERT_EQ(mesh.normals.size(), 8U);
  for (std::size_t v = 0; v < 8; ++v) {
    EXPECT_NEAR(glm::length(mesh.normals[v]), 1, 1e-6);
    EXPECT_GT(glm::dot(mesh.normals[v], mesh.positions[v] - 0.5F), 0.7F);
  }
  EXPECT_EQ(measure_topology(mesh).open_edges, 0U);
}

TEST(ShadingNormals, AgreeWithAllTriangles) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    Mesh mesh = rough(24, seed);
    const NormalAgreement before = measure_normal_agreement(mesh);
    EXPECT_EQ(before.pairs, 3 * mesh.triangles.size());
    EXPECT_GT(before.against, before.pairs / 100);
    const auto copies = compute_shading_normals(mesh, {.planes = {}, .crease_degrees = 30}, "rough", Context());
    ASSERT_TRUE(copies);
    EXPECT_EQ(measure_normal_agreement(mesh).against, 0U);
    EXPECT_GT(*copies, 0U);
    EXPECT_LT(*copies, 24 * 24);
    for (const glm::vec3& normal : mesh.normals) EXPECT_NEAR(glm::length(normal), 1, 1e-5);
  }
}

TEST(ShadingNormals, KeepsNormalsThatAgree) {
  // A flat fan with a slightly raised center: its normal tilts less than the triangles do.
  Mesh mesh = test::make_mesh({{0, 0, 0.5F}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                              {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}});
  mesh.normals = Buffer<glm::vec3>(5);
  const glm::vec3 leaning = glm::normalize(glm::vec3(0.1F, 0, 1));
  std::ranges::fill(mesh.normals.span(), leaning);
  ASSERT_TRUE(compute_shading_normals(mesh, {.planes = {}, .crease_degrees = 30}, "fan", Context()));
  EXPECT_EQ(mesh.positions.size(), 5U);
  EXPECT_EQ(mesh.normals[0], leaning);
}

TEST(ShadingNormals, CopiesHaveAllVertexAttributes) {
  Mesh mesh = cube();
  Attribute number;
  number.name = "number";
  number.type = ComponentType::u8;
  number.values = Buffer<std::byte>(8);
  for (std::size_t v = 0; v < 8; ++v) number.values[v] = static_cast<std::byte>(v);
  mesh.attributes.push_back(std::move(number));
  ASSERT_TRUE(compute_shading_normals(mesh, {.planes = {}, .crease_degrees = 30}, "cube", Context()));
  ASSERT_EQ(mesh.attributes.front().values.size(), mesh.positions.size());
  const Mesh before = cube();
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    EXPECT_EQ(mesh.positions[v], before.positions[static_cast<std::size_t>(mesh.attributes.front().values[v])]);
  }
}

TEST(ShadingNormals, DoNotDependOnThreads) {
  const auto shaded = [](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    Mesh mesh = rough(150, 7);
    EXPECT_TRUE(compute_shading_normals(mesh, {.planes = {}, .crease_degrees = 30}, "rough", Context()));
    return mesh;
  };
  const Mesh one = shaded(1);
  const Mesh three = shaded(3);
  EXPECT_TRUE(std::ranges::equal(one.positions, three.positions));
  EXPECT_TRUE(std::ranges::equal(one.normals, three.normals));
  EXPECT_TRUE(std::ranges::equal(one.triangles, three.triangles));
}

TEST(ShadingNormals, AcceptsDegenerateAndRandomTriangles) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 engine(seed);
    std::vector<glm::vec3> positions;
    for (int v = 0; v < 40; ++v) positions.emplace_back(engine() % 3, engine() % 3, engine() % 3);
    Mesh mesh = test::make_mesh(positions, test::random_triangles(200, 40, seed));
    ASSERT_TRUE(compute_shading_normals(mesh, {.planes = {}, .crease_degrees = 30}, "random", Context()));
    ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
    EXPECT_EQ(measure_normal_agreement(mesh).against, 0U);
    for (const glm::vec3& normal : mesh.normals) EXPECT_NEAR(glm::length(normal), 1, 1e-5);
  }
}

TEST(ShadingNormals, KeepsToMemoryLimit) {
  Mesh mesh = cube();
  const auto done =
      compute_shading_normals(mesh, {.planes = {}, .crease_degrees = 30}, "a.raw", Context(MemoryBudget(100)));
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("a.raw"), std::string::npos);
}

}  // namespace
}  // namespace isoextract::mesh
