// The stability cases pass, and their checks find the failures of plain float32 in the same cases.
#include "bench/stability.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "accuracy/extraction_comparison.hpp"
#include "changed_extractor.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::bench {
namespace {

class Stability : public testing::TestWithParam<extract::Method> {};

INSTANTIATE_TEST_SUITE_P(Methods, Stability, testing::Values(extract::Method::mc, extract::Method::mt),
                         test::method_name);

TEST_P(Stability, PassesAllCases) {
  const auto cpu = extract::make_cpu_extractor();
  for (const StabilityCase& test : stability_cases()) {
    const StabilityRow row = run_stability_case(test, extract::method_info(GetParam()), *cpu, Context());
    for (const std::string& failure : row.failures) ADD_FAILURE() << test.name << ": " << failure;
  }
}

// Moves one vertex a little along its edge and drops one triangle.
void be_careless(const extract::ExtractOptions& /*options*/, mesh::Mesh& mesh) {
  if (mesh.triangles.empty()) return;
  mesh.triangles[0] = mesh.triangles[1];
  for (int axis = 0; axis < 3; ++axis) mesh.positions[9][axis] *= 1.00001F;
}

TEST_P(Stability, FailsCarelessExtractor) {
  test::ChangedExtractor careless(be_careless, "careless");
  for (const StabilityCase& test : stability_cases()) {
    const StabilityRow row = run_stability_case(test, extract::method_info(GetParam()), careless, Context());
    EXPECT_EQ(row.failures.empty(), row.findings.vertices == 0) << test.name;
    EXPECT_EQ(row.backend, "careless");
  }
}

double stored_value(const field::ScalarField& field, const glm::ivec3& p) {
  const auto& dense = std::get<field::DenseSamples>(field.samples);
  const glm::i64vec3 q(p);
  return visit_sample_type(dense.type, [&]<class T>(std::type_identity<T>) {
    return static_cast<double>(static_cast<const T*>(dense.data)[q.x + dense.dims.x * (q.y + dense.dims.y * q.z)]);
  });
}

// Recomputes the vertices of `mesh` in float32 alone: samples, crossing and world position, without local origin and
// without margin at edge ends.
mesh::Mesh in_plain_float32(const mesh::Mesh& mesh, const StabilityScene& scene,
                            const extract::ExtractOptions& options) {
  const auto edges = grid_edges(mesh, scene.field, options, extract::method_info(options.method).traits);
  mesh::Mesh plain;
  plain.positions = Buffer<glm::vec3>(mesh.positions.size());
  plain.triangles = Buffer<glm::uvec3>(mesh.triangles.size());
  std::copy(mesh.triangles.begin(), mesh.triangles.end(), plain.triangles.begin());
  const glm::mat3 linear(options.output_from_index.linear);
  const glm::vec3 offset(options.output_from_index.offset);
  const auto iso = static_cast<float>(options.iso);
  for (std::size_t v = 0; v < edges.size(); ++v) {
    const GridEdge edge = edges[v].value();
    const auto f0 = static_cast<float>(stored_value(scene.field, edge.low));
    const auto f1 = static_cast<float>(stored_value(scene.field, edge.low + edge.step));
    const float t = (iso - f0) / (f1 - f0);
    plain.positions[v] = linear * (glm::vec3(edge.low) + t * glm::vec3(edge.step)) + offset;
  }
  return plain;
}

TEST_P(Stability, PlainFloat32FailsAsListed) {
  const auto cpu = extract::make_cpu_extractor();
  for (const StabilityCase& test : stability_cases()) {
    SCOPED_TRACE(test.name);
    const StabilityScene scene = test.make();
    extract::ExtractOptions options = scene.options;
    options.method = GetParam();
    const auto extraction = cpu->extract(scene.field, options, Context());
    if (!extraction || extraction->mesh.triangles.empty()) {
      EXPECT_FALSE(test.float32_fails) << "there is nothing to fail with";
      continue;
    }
    const mesh::Mesh plain = in_plain_float32(extraction->mesh, scene, options);
    // Ten times the extractors' limits, so that the result does not depend on the last digit.
    const auto found = failures(
        check_stability(plain, scene.field, options, extract::method_info(options.method).traits),
        scene.closed && options.nan != extract::NanPolicy::hole, 10 * accuracy::kStabilityUlps, 10 * scene.voxels);
    EXPECT_EQ(!found.empty(), test.float32_fails) << (found.empty() ? "nothing" : found.front());
    if (!found.empty()) RecordProperty(std::string(test.name), found.front());
  }
}

TEST(StabilityTable, DescribesEveryCase) {
  std::set<std::string_view> names;
  for (const StabilityCase& test : stability_cases()) {
    EXPECT_TRUE(names.insert(test.name).second) << test.name;
    EXPECT_TRUE(test.extreme.ends_with('.')) << test.name;
    EXPECT_EQ(test.plain.starts_with("survives"), !test.float32_fails) << test.name;
  }
  EXPECT_GE(names.size(), 30U);
}

// Tests the checks: each test plants one defect.
class Checks : public testing::Test {
 protected:
  void SetUp() override {
    field_ = test::dense_field<float>({8, 8, 8}, [](int i, int j, int k) {
      return 2.6 - glm::length(glm::dvec3(i, j, k) - glm::dvec3(3.4, 3.6, 3.5));
    });
    mesh_ = test::extract(field_, options_).mesh;
    ASSERT_TRUE(found().empty()) << found().front();
  }
  StabilityFindings check() const {
    return check_stability(mesh_, field_, options_, extract::method_info(options_.method).traits);
  }
  std::vector<std::string> found() const { return failures(check(), true, 2, 1e-5); }

  field::ScalarField field_;
  extract::ExtractOptions options_;
  mesh::Mesh mesh_;
};

TEST_F(Checks, FindVertexOffItsEdge) {
  glm::vec3& p = mesh_.positions[5];
  const int whole = p.x == std::round(p.x) ? 0 : 1;
  p[whole] += 0.01F;
  EXPECT_EQ(check().off_edge, 1U);
  EXPECT_FALSE(found().empty());
}

TEST_F(Checks, FindVertexMovedAlongItsEdge) {
  glm::vec3& p = mesh_.positions[5];
  for (int axis = 0; axis < 3; ++axis) {
    if (p[axis] != std::round(p[axis])) p[axis] += p[axis] - std::floor(p[axis]) < 0.5F ? 0.01F : -0.01F;
  }
  const StabilityFindings findings = check();
  EXPECT_EQ(findings.off_edge, 0U);
  EXPECT_NEAR(findings.voxels, 0.01, 1e-6);
  EXPECT_GT(findings.ulps, 1000);
  EXPECT_EQ(found().size(), 2U);
}

TEST_F(Checks, FindVertexOnSample) {
  mesh_.positions[5] = glm::round(mesh_.positions[5]);
  EXPECT_EQ(check().off_edge, 1U);
}

TEST_F(Checks, FindNonFiniteVertex) {
  mesh_.positions[5].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(check().not_finite, 1U);
}

TEST_F(Checks, FindNormalOfOtherLength) {
  mesh_.normals = Buffer<glm::vec3>(mesh_.positions.size());
  for (glm::vec3& normal : mesh_.normals) normal = {0, 0, 1};
  EXPECT_EQ(check().not_finite, 0U);
  mesh_.normals[5] = {0, 0, 2};
  EXPECT_EQ(check().not_finite, 1U);
  ASSERT_EQ(found().size(), 1U);
  EXPECT_NE(found()[0].find("normals not of length 1"), std::string::npos) << found()[0];
}

TEST_F(Checks, FindDuplicates) {
  mesh_.positions[5] = mesh_.positions[6];
  EXPECT_EQ(check().repeated, 1U);
  mesh_.triangles[3] = mesh_.triangles[4];
  const StabilityFindings findings = check();
  EXPECT_EQ(findings.repeated, 2U);
  EXPECT_GT(findings.open_edges, 0U);
}

TEST_F(Checks, FindFlippedTriangle) {
  std::swap(mesh_.triangles[3].x, mesh_.triangles[3].y);
  EXPECT_EQ(check().unsound, 3U);
}

}  // namespace
}  // namespace isoextract::bench
