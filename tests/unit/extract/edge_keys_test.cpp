// Mesh::edges: the grid edge of each vertex.
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

using KeyTriangle = std::array<mesh::EdgeKey, 3>;

// Expects that each key is the edge that strictly contains the vertex, or the sample at the vertex.
void expect_keys_fit(const mesh::Mesh& mesh) {
  ASSERT_EQ(mesh.edges.size(), mesh.positions.size());
  for (std::size_t v = 0; v < mesh.edges.size(); ++v) {
    const glm::vec3 away = mesh.positions[v] - glm::vec3(mesh.edges[v].low);
    const int direction = mesh.edges[v].direction;
    ASSERT_GE(direction, 0);
    ASSERT_LE(direction, 7);
    const float along = std::max({away.x, away.y, away.z});
    for (int axis = 0; axis < 3; ++axis) {
      if ((direction >> axis & 1) == 0) {
        EXPECT_EQ(away[axis], 0);
      } else {
        EXPECT_GT(away[axis], 0);
        EXPECT_LT(away[axis], 1);
        EXPECT_NEAR(away[axis], along, 1e-5);
      }
    }
  }
}

std::multiset<KeyTriangle> key_triangles(const mesh::Mesh& mesh) {
  std::multiset<KeyTriangle> set;
  for (const glm::uvec3& t : mesh.triangles) {
    KeyTriangle keys{mesh.edges[t.x], mesh.edges[t.y], mesh.edges[t.z]};
    std::rotate(keys.begin(), std::min_element(keys.begin(), keys.end()), keys.end());
    set.insert(keys);
  }
  return set;
}

std::uint64_t distinct_keys(const mesh::Mesh& mesh) { return std::set(mesh.edges.begin(), mesh.edges.end()).size(); }

class EdgeKeys : public testing::TestWithParam<Method> {
 protected:
  [[nodiscard]] ExtractOptions options(double iso) const {
    ExtractOptions o = test::options_of(GetParam(), iso);
    o.edge_keys = true;
    return o;
  }
  // Random values surrounded by background, so that dense and sparse fields have the same surface.
  static field::ScalarField noise(double missing_share) {
    std::mt19937 engine(5);
    std::uniform_int_distribution<int> value(0, 999);
    std::bernoulli_distribution lost(missing_share);
    const glm::ivec3 dims(24, 16, 16);
    return test::dense_field<float>(dims, [&](int i, int j, int k) {
      const glm::ivec3 p(i, j, k);
      const int random = value(engine);
      if (glm::any(glm::equal(p, glm::ivec3(0))) || glm::any(glm::equal(p, dims - 1))) return -1.0F;
      return lost(engine) ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(random);
    });
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, EdgeKeys, testing::ValuesIn(test::methods_with(&MethodTraits::vertices_on_edges)),
                         test::method_name);

TEST_P(EdgeKeys, NameEdgeOfEveryVertex) {
  const field::ScalarField dense = noise(0);
  const mesh::Mesh a = test::extract(dense, options(600)).mesh;
  const mesh::Mesh b = test::extract(test::sparse_copy<float>(dense, -1), options(600)).mesh;
  for (const mesh::Mesh* mesh : {&a, &b}) {
    expect_keys_fit(*mesh);
    EXPECT_EQ(distinct_keys(*mesh), mesh->edges.size());
  }
  EXPECT_FALSE(a.edges.empty());
  EXPECT_EQ(key_triangles(a), key_triangles(b));
}

TEST_P(EdgeKeys, CountFromFieldOriginInRegions) {
  const field::ScalarField dense = noise(0);
  const auto whole = key_triangles(test::extract(dense, options(600)).mesh);
  ExtractOptions o = options(600);
  o.region = field::IndexBox{{3, 5, 2}, {20, 12, 9}};
  const auto part = key_triangles(test::extract(dense, o).mesh);
  EXPECT_TRUE(std::includes(whole.begin(), whole.end(), part.begin(), part.end()));
  o.cap = true;
  const mesh::Mesh a = test::extract(dense, o).mesh;
  const mesh::Mesh b = test::extract(test::sparse_copy<float>(dense, -1), o).mesh;
  for (const mesh::Mesh* mesh : {&a, &b}) {
    expect_keys_fit(*mesh);
    EXPECT_EQ(distinct_keys(*mesh), mesh->edges.size());
    EXPECT_TRUE(std::ranges::any_of(mesh->edges, [](const mesh::EdgeKey& key) { return key.direction == 0; }));
  }
  EXPECT_EQ(key_triangles(a), key_triangles(b));
}

TEST_P(EdgeKeys, AreEqualForVerticesSplitAtHoles) {
  const field::ScalarField dense = noise(0.1);
  ExtractOptions o = options(600);
  o.nan = NanPolicy::hole;
  const mesh::Mesh a = test::extract(dense, o).mesh;
  const mesh::Mesh b = test::extract(test::sparse_copy<float>(dense, -1), o).mesh;
  for (const mesh::Mesh* mesh : {&a, &b}) {
    expect_keys_fit(*mesh);
    EXPECT_LT(distinct_keys(*mesh), mesh->edges.size());
  }
  EXPECT_EQ(key_triangles(a), key_triangles(b));
}

TEST_P(EdgeKeys, ChangeNothingElse) {
  const field::ScalarField dense = noise(0);
  const field::ScalarField sparse = test::sparse_copy<float>(dense, -1);
  for (const field::ScalarField* field : {&dense, &sparse}) {
    ExtractOptions o = options(600);
    const mesh::Mesh with = test::extract(*field, o).mesh;
    o.edge_keys = false;
    const mesh::Mesh without = test::extract(*field, o).mesh;
    EXPECT_TRUE(without.edges.empty());
    EXPECT_TRUE(std::ranges::equal(with.positions, without.positions));
    EXPECT_TRUE(std::ranges::equal(with.triangles, without.triangles));
  }
}

TEST(EdgeKey, SortsLikeDenseMemory) {
  const std::array ordered{mesh::EdgeKey{{5, 5, 0}, 7}, mesh::EdgeKey{{9, 0, 1}, 4}, mesh::EdgeKey{{-3, 1, 1}, 1},
                           mesh::EdgeKey{{2, 1, 1}, 0}, mesh::EdgeKey{{2, 1, 1}, 1}};
  EXPECT_TRUE(std::is_sorted(ordered.begin(), ordered.end()));
  EXPECT_FALSE(ordered[3] == ordered[4]);
  EXPECT_FALSE(ordered[4] < ordered[4]);
}

}  // namespace
}  // namespace isoextract::extract
