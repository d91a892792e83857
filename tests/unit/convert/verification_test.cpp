#include "convert/verification.hpp"
#include "convert/json_values.hpp"

#include <gtest/gtest.h>

#include "field/demo_field.hpp"
#include "support/meshes.hpp"

namespace isoextract::convert {
namespace {

// Fails the test if it is asked to extract.
class Idle final : public extract::Extractor {
 public:
  explicit Idle(bool has_it) : has_it_(has_it) {}
  [[nodiscard]] std::string_view name() const override { return "idle"; }
  [[nodiscard]] std::string device() const override { return "none"; }
  [[nodiscard]] bool has(extract::Method /*method*/) const override { return has_it_; }

 private:
  [[nodiscard]] Result<extract::Extraction> run(const field::ScalarField&, const extract::ExtractOptions&,
                                                const Context&) override {
    ADD_FAILURE() << "there is nothing to compare with";
    return extract::Extraction();
  }

  bool has_it_;
};

class Verification : public testing::Test {
 protected:
  Result<VerificationRecord> compare(const extract::MethodInfo& method, extract::Extractor& second) {
    extract::ExtractOptions options;
    options.method = method.method;
    options.edge_keys = method.traits.vertices_on_edges;
    const mesh::Mesh mesh = test::extract(field_, options).mesh;
    return compare_backends(field_, options, method, mesh, *cpu_, second, Context());
  }

  void expect_not_applicable(const VerificationRecord& record, const std::string& why) {
    EXPECT_EQ(record.not_applicable, why);
    EXPECT_TRUE(check_verification("field", record));
    const Json json = json_of(report_of(record, "field").entries.front());
    EXPECT_TRUE(json.at("passed").is_null());
    EXPECT_EQ(json.at("not_applicable"), why);
    EXPECT_FALSE(json.contains("triangles")) << "nothing was counted";
  }

  field::ScalarField field_ = field::make_demo_field("demo:torus?size=16", Context()).value();
  std::unique_ptr<extract::Extractor> cpu_ = extract::make_cpu_extractor();
};

TEST_F(Verification, ComparesMeshesWithEdgeKeys) {
  const auto record = compare(extract::method_info(extract::Method::mt), *extract::make_cpu_extractor());
  ASSERT_TRUE(record);
  EXPECT_EQ(record->not_applicable, "");
  EXPECT_GT(record->comparison.triangles.total[1], 0U);
  const Figures figures = report_of(*record, "field").entries.front();
  EXPECT_EQ(value_at<bool>(figures, {Key::passed}), true);
  EXPECT_EQ(find(figures, {Key::not_applicable}), nullptr);
}

TEST_F(Verification, PrintsNoSuccessIfBackendsDiffer) {
  VerificationRecord record;
  record.iso = 0.5;
  record.backends = {"cpu", "gpu"};
  EXPECT_EQ(report_of(record, "field").lines.size(), 1U);
  record.differences = {"one has another triangle"};
  const StageReport report = report_of(record, "field");
  ASSERT_TRUE(report.error);
  EXPECT_TRUE(report.lines.empty()) << report.lines.front().text;
}

TEST_F(Verification, SkipsMethodsWithVerticesOffEdges) {
  extract::MethodInfo nets = extract::method_info(extract::Method::mc);
  nets.title = "made-up nets";
  nets.traits.vertices_on_edges = false;
  Idle idle(true);
  const auto record = compare(nets, idle);
  ASSERT_TRUE(record) << record.error().message;
  expect_not_applicable(*record, "made-up nets: the vertices do not lie on edges of the grid");
}

TEST_F(Verification, SkipsBackendWithoutMethod) {
  Idle idle(false);
  const auto record = compare(extract::method_info(extract::Method::mc), idle);
  ASSERT_TRUE(record) << record.error().message;
  expect_not_applicable(*record, "idle does not have marching cubes");
}

}  // namespace
}  // namespace isoextract::convert
