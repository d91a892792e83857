#include "accuracy/extraction_comparison.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "accuracy/float_spacing.hpp"
#include "field/demo_field.hpp"
#include "support/fields.hpp"
#include "support/mesh_copies.hpp"
#include "support/meshes.hpp"

namespace isoextract::accuracy {
namespace {

ExtractionComparison compare(const mesh::Mesh& a, const mesh::Mesh& b) {
  auto result = compare_extractions(a, b, Context());
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return *result;
}

bool same(const ExtractionComparison& comparison) { return differences(comparison, {"a", "b"}).empty(); }

// Returns all differences in one string.
std::string told(const ExtractionComparison& comparison) {
  std::string text;
  for (const std::string& sentence : differences(comparison, {"cpu", "gpu"})) text += sentence + "\n";
  return text;
}

class ExtractionComparisonTest : public testing::TestWithParam<extract::Method> {
 protected:
  [[nodiscard]] extract::ExtractOptions options() const {
    extract::ExtractOptions o;
    o.method = GetParam();
    o.edge_keys = true;
    o.smooth_normals = true;
    return o;
  }
  [[nodiscard]] mesh::Mesh torus() const {
    return test::extract(field::make_demo_field("demo:torus?size=24", Context()).value(), options()).mesh;
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, ExtractionComparisonTest, testing::Values(extract::Method::mc, extract::Method::mt),
                         test::method_name);

TEST_P(ExtractionComparisonTest, IgnoresOrder) {
  const mesh::Mesh mesh = torus();
  for (const unsigned seed : {1U, 2U, 3U}) {
    const ExtractionComparison result = compare(mesh, test::shuffled(mesh, seed));
    EXPECT_EQ(told(result), "");
    EXPECT_EQ(result.triangles.total[0], mesh.triangles.size());
    EXPECT_EQ(result.vertices[1], mesh.positions.size());
    EXPECT_EQ(result.ulps, 0);
    EXPECT_EQ(result.degrees, 0);
    EXPECT_TRUE(result.normals_compared);
  }
}

// Dense and sparse samples are two backends that need no GPU.
TEST_P(ExtractionComparisonTest, FindsNoDifferenceBetweenDenseAndSparse) {
  std::mt19937 engine(3);
  std::uniform_int_distribution<int> value(0, 99);
  const field::ScalarField dense = test::dense_field<float>({24, 16, 16}, [&](int, int, int) {
    const int random = value(engine);
    return random < 5 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(random);
  });
  const field::ScalarField sparse = test::sparse_copy<float>(dense, -1);
  extract::ExtractOptions o = options();
  o.iso = 60;
  o.region = field::IndexBox{{1, 2, 1}, {20, 13, 14}};
  o.smooth_normals = false;  // they would use samples outside the data, which dense data lack
  o.cap = true;
  for (const extract::NanPolicy nan : {extract::NanPolicy::outside, extract::NanPolicy::hole}) {
    o.nan = nan;
    const mesh::Mesh a = test::extract(dense, o).mesh;
    EXPECT_FALSE(a.triangles.empty());
    EXPECT_EQ(told(compare(a, test::extract(sparse, o).mesh)), "");
    EXPECT_EQ(told(compare(a, test::shuffled(a, 4))), "");
  }
}

TEST_P(ExtractionComparisonTest, FindsDroppedTriangle) {
  const mesh::Mesh mesh = torus();
  const ExtractionComparison result = compare(mesh, test::without_triangle(mesh, 17));
  EXPECT_EQ(result.triangles.only[0], 1U);
  EXPECT_EQ(result.triangles.only[1], 0U);
  EXPECT_FALSE(same(result));
  ASSERT_TRUE(result.triangles.example[0]);
  EXPECT_EQ((*result.triangles.example[0])[1], mesh.position(mesh.triangles[17].y));
  EXPECT_NE(told(result).find("triangles are in cpu only"), std::string::npos);
  EXPECT_EQ(compare(test::without_triangle(mesh, 17), mesh).triangles.only[1], 1U);
}

TEST_P(ExtractionComparisonTest, FindsDuplicateTriangle) {
  const mesh::Mesh mesh = torus();
  mesh::Mesh twice = test::copy_of(mesh);
  twice.triangles[5] = twice.triangles[6];
  const ExtractionComparison result = compare(mesh, twice);
  EXPECT_EQ(result.triangles.only[0], 1U);
  EXPECT_EQ(result.triangles.only[1], 1U);
}

TEST_P(ExtractionComparisonTest, FindsFlippedTriangle) {
  const mesh::Mesh mesh = torus();
  mesh::Mesh flipped = test::shuffled(mesh, 9);
  std::swap(flipped.triangles[3].x, flipped.triangles[3].y);
  const ExtractionComparison result = compare(mesh, flipped);
  EXPECT_EQ(result.triangles.only[0], 1U);
  EXPECT_EQ(result.triangles.only[1], 1U);
  EXPECT_EQ(result.vertices_only[0], 0U);
  EXPECT_FALSE(same(result));
}

TEST_P(ExtractionComparisonTest, FindsMovedVertex) {
  const mesh::Mesh mesh = torus();
  std::uint32_t vertex = 0;  // with a small coordinate, whose own spacing must not count
  const auto smallness = [&](std::uint32_t v) { return mesh.positions[v].x / std::max(mesh.positions[v].y, 1e-3F); };
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (smallness(v) < smallness(vertex)) vertex = v;
  }
  const glm::vec3 p = mesh.positions[vertex];
  const double ulp = float_spacing(std::max({p.x, p.y, p.z}));
  for (const int ulps : {1, 2, 3, 1000}) {
    mesh::Mesh moved = test::copy_of(mesh);
    moved.positions[vertex].x = static_cast<float>(static_cast<double>(p.x) + ulps * ulp);
    const ExtractionComparison result = compare(mesh, test::shuffled(moved, 1));
    EXPECT_NEAR(result.ulps, ulps, 0.51);
    EXPECT_EQ(result.farthest, mesh.edges[vertex]);
    EXPECT_EQ(same(result), ulps <= 2) << told(result);
    EXPECT_EQ(result.triangles.only[0], 0U) << "its edge is still the same";
  }
}

TEST_P(ExtractionComparisonTest, FindsSwappedKeys) {
  const mesh::Mesh mesh = torus();
  mesh::Mesh swapped = test::copy_of(mesh);
  std::swap(swapped.edges[10], swapped.edges[200]);
  const ExtractionComparison result = compare(mesh, swapped);
  EXPECT_FALSE(same(result));
  EXPECT_GT(result.ulps, 1000);
  EXPECT_GT(result.triangles.only[0], 0U);
  EXPECT_EQ(result.vertices_only[0], 0U);
}

TEST_P(ExtractionComparisonTest, FindsChangedKey) {
  const mesh::Mesh mesh = torus();
  mesh::Mesh other = test::copy_of(mesh);
  other.edges[10].low.x += 100;
  const ExtractionComparison result = compare(mesh, other);
  EXPECT_EQ(result.vertices_only[0], 1U);
  EXPECT_EQ(result.vertices_only[1], 1U);
  EXPECT_EQ(result.vertex_example[0], mesh.edges[10]);
  EXPECT_EQ(result.vertex_example[1], other.edges[10]);
  EXPECT_GT(result.triangles.only[0], 2U) << "all around it";
  // A key that exists already: as if the vertex were split.
  other.edges[10] = other.edges[11];
  EXPECT_EQ(compare(mesh, other).vertices_only[1], 1U);
}

TEST_P(ExtractionComparisonTest, FindsTurnedNormal) {
  const mesh::Mesh mesh = torus();
  mesh::Mesh turned = test::copy_of(mesh);
  const glm::vec3 n = mesh.normals[7];
  const glm::vec3 side = glm::normalize(glm::cross(n, std::abs(n.x) < 0.5F ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0)));
  turned.normals[7] = glm::normalize(n + static_cast<float>(std::tan(glm::radians(0.5))) * side);
  const ExtractionComparison result = compare(mesh, turned);
  EXPECT_NEAR(result.degrees, 0.5, 1e-4);
  EXPECT_EQ(result.largest_angle_edge, mesh.edges[7]);
  EXPECT_FALSE(same(result));
  turned.normals = {};
  EXPECT_NE(told(compare(mesh, turned)).find("only one of the meshes has normals"), std::string::npos);
}

TEST_P(ExtractionComparisonTest, FindsMovedOriginAndNan) {
  const mesh::Mesh mesh = torus();
  mesh::Mesh other = test::copy_of(mesh);
  other.origin.x += 1;
  const ExtractionComparison moved = compare(mesh, other);
  EXPECT_TRUE(moved.origins_differ);
  EXPECT_GT(moved.ulps, 1000) << "positions are compared where they are";
  other = test::copy_of(mesh);
  other.positions[4].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isinf(compare(mesh, other).ulps));
  EXPECT_FALSE(same(compare(mesh, other)));
  EXPECT_FALSE(same(compare(other, other))) << "not a number is no place, on both sides";
}

TEST_P(ExtractionComparisonTest, ReportsInvalidIndexAsDifference) {
  const mesh::Mesh mesh = torus();
  mesh::Mesh broken = test::copy_of(mesh);
  broken.triangles[2].y = 1U << 31;
  const ExtractionComparison result = compare(mesh, broken);
  EXPECT_EQ(result.triangles.only[0], 1U);
  EXPECT_EQ(result.triangles.only[1], 1U);
  EXPECT_NE(told(result).find("nan"), std::string::npos);
}

TEST_P(ExtractionComparisonTest, ComparesEmptyMeshes) {
  const mesh::Mesh mesh = torus();
  EXPECT_TRUE(same(compare(mesh::Mesh{}, mesh::Mesh{})));
  const ExtractionComparison result = compare(mesh::Mesh{}, mesh);
  EXPECT_EQ(result.vertices_only[1], mesh.positions.size());
  EXPECT_EQ(result.triangles.only[1], mesh.triangles.size());
  EXPECT_EQ(compare(mesh, mesh::Mesh{}).triangles.only[0], mesh.triangles.size());
}

TEST_P(ExtractionComparisonTest, FailsWithoutKeysOrMemory) {
  const mesh::Mesh mesh = torus();
  mesh::Mesh keyless = test::copy_of(mesh);
  keyless.edges = {};
  const auto without = compare_extractions(mesh, keyless, Context());
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().code, ErrorCode::verification);
  const auto small = compare_extractions(mesh, mesh, Context(MemoryBudget(1000)));
  ASSERT_FALSE(small);
  EXPECT_EQ(small.error().code, ErrorCode::out_of_memory);
}

TEST_P(ExtractionComparisonTest, IsIndependentOfThreads) {
  const mesh::Mesh mesh = torus();
  mesh::Mesh other = test::shuffled(mesh, 2);
  for (std::size_t v = 0; v < other.positions.size(); v += 7) other.positions[v].z += 1e-4F;
  for (std::size_t t = 0; t < other.triangles.size(); t += 5) std::swap(other.triangles[t].x, other.triangles[t].z);
  const std::string all = told(compare(mesh, other));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(told(compare(mesh, other)), all);
  EXPECT_NE(all, "");
}

TEST(FloatSpacing, MatchesNextAfter) {
  for (const float size : {1.0F, 1.5F, 0.999F, 3e38F, 1e-37F, 7.0F, 16777216.0F}) {
    const float next = std::nextafter(size, std::numeric_limits<float>::infinity());
    EXPECT_EQ(float_spacing(static_cast<double>(size)), static_cast<double>(next) - static_cast<double>(size)) << size;
  }
  EXPECT_EQ(float_spacing(0), static_cast<double>(std::numeric_limits<float>::denorm_min()));
  EXPECT_EQ(float_spacing(1e-44), static_cast<double>(std::numeric_limits<float>::denorm_min()));
  EXPECT_GT(float_spacing(static_cast<double>(std::numeric_limits<float>::max())), 1e30);
}

TEST(EdgeText, NamesTheSampleAndTheAxes) {
  EXPECT_EQ(edge_text({{1, -2, 3}, 5}), "(1, -2, 3) along xz");
  EXPECT_EQ(edge_text({{1, 2, 3}, 0}), "(1, 2, 3)");
}

}  // namespace
}  // namespace isoextract::accuracy
