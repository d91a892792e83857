#include "accuracy/analytic_error.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "field/demo_field.hpp"
#include "support/meshes.hpp"

namespace isoextract::accuracy {
namespace {

constexpr double kPi = std::numbers::pi;

struct Extracted {
  field::ScalarField field;
  extract::ExtractOptions options;
  mesh::Mesh mesh;
};

Extracted extract_demo(const std::string& spec, double iso, const field::Affine& after = {}, bool cap = false) {
  Extracted result{field::make_demo_field(spec, Context()).value(), {}, {}};
  result.options.iso = iso;
  result.options.cap = cap;
  result.options.smooth_normals = true;
  result.options.output_from_index = after.after(result.field.index_to_world);
  result.mesh = test::extract(result.field, result.options).mesh;
  return result;
}

// Compares the gradients of all formulas with finite differences.
TEST(AnalyticField, GradientsMatchFiniteDifferences) {
  for (const char* name : {"sphere", "torus", "gyroid", "marschner-lobb", "metaballs"}) {
    const field::AnalyticField* field = field::find_analytic_field(name);
    ASSERT_NE(field, nullptr) << name;
    for (const glm::dvec3 p : {glm::dvec3(0.3, -0.2, 0.4), glm::dvec3(-0.7, 0.1, 0.05), glm::dvec3(0.9, 0.8, -0.95)}) {
      const field::Dual here = field->value_and_gradient(p);
      EXPECT_EQ(here.value, field->value(p));
      for (int axis = 0; axis < 3; ++axis) {
        constexpr double kStep = 1e-5;
        glm::dvec3 d(0);
        d[axis] = kStep;
        EXPECT_NEAR((field->value(p + d) - field->value(p - d)) / (2 * kStep), here.gradient[axis], 1e-4) << name;
      }
    }
  }
  EXPECT_EQ(field::find_analytic_field("random"), nullptr);
}

TEST(AnalyticError, ScalesWithRotatedPlacement) {
  const Extracted plain = extract_demo("demo:torus?size=48", 0);
  const field::Affine turned{1000.0 * glm::dmat3(1, 0, 0, 0, 0, -1, 0, 1, 0), glm::dvec3(5e6, 0, -7)};
  const Extracted placed = extract_demo("demo:torus?size=48", 0, turned);
  const auto a = measure_analytic_error(plain.mesh, plain.field, plain.options, nullptr, {}, Context()).value().value();
  const auto b =
      measure_analytic_error(placed.mesh, placed.field, placed.options, nullptr, {}, Context()).value().value();
  EXPECT_TRUE(a.closed_form);
  EXPECT_NEAR(b.unit, 1000, 1e-9);
  EXPECT_NEAR(b.interior.rms.world / a.interior.rms.world, 1000, 1e-2);
  EXPECT_NEAR(b.interior.rms.voxels, a.interior.rms.voxels, 1e-6);
  EXPECT_NEAR(b.smooth_normals.rms_degrees, a.smooth_normals.rms_degrees, 1e-4);
  EXPECT_NEAR(b.flat_normals.rms_degrees, a.flat_normals.rms_degrees, 1e-3);
  EXPECT_LT(a.smooth_normals.rms_degrees, 2);
  EXPECT_NEAR(a.area / (4 * kPi * kPi * 0.6 * 0.25), 1, 0.01);
  EXPECT_NEAR(*b.volume / (1e9 * 2 * kPi * kPi * 0.6 * 0.25 * 0.25), 1, 0.01);
  const Extracted stretched = extract_demo("demo:torus?size=48", 0, field::scaling({1, 1, 2}));
  EXPECT_FALSE(
      measure_analytic_error(stretched.mesh, stretched.field, stretched.options, nullptr, {}, Context()).value());
}

// Vertices moved outward by a known distance have that error.
TEST(AnalyticError, MeasuresInflationOfSphere) {
  Extracted sphere = extract_demo("demo:sphere?size=64", 0.1);
  for (std::size_t v = 0; v < sphere.mesh.positions.size(); ++v) {
    sphere.mesh.positions[v] += 0.01F * glm::normalize(sphere.mesh.positions[v]);
  }
  const auto error =
      measure_analytic_error(sphere.mesh, sphere.field, sphere.options, nullptr, {}, Context()).value().value();
  EXPECT_NEAR(error.vertices.rms.world, 0.01, 2e-4);
  EXPECT_NEAR(error.vertices.rms.voxels, 0.01 * 63 / 2, 2e-2);
}

TEST(AnalyticError, ConvergesWithoutClosedForm) {
  for (const char* spec : {"demo:gyroid?size=64", "demo:metaballs?size=64"}) {
    const Extracted open = extract_demo(spec, 0.1);
    const auto error =
        measure_analytic_error(open.mesh, open.field, open.options, nullptr, {}, Context()).value().value();
    EXPECT_FALSE(error.closed_form);
    EXPECT_EQ(error.interior.unmeasured(), 0U) << spec;
    EXPECT_LT(error.interior.max.voxels, 0.2) << spec;
    EXPECT_FALSE(error.volume) << "not closed";
    const Extracted capped = extract_demo(spec, 0.1, {}, true);
    const auto closed =
        measure_analytic_error(capped.mesh, capped.field, capped.options, nullptr, {}, Context()).value().value();
    EXPECT_TRUE(closed.volume);
    EXPECT_NEAR(closed.area, error.area, 1e-9) << "caps do not count";
    EXPECT_EQ(closed.vertices.points, error.vertices.points);
  }
}

}  // namespace
}  // namespace isoextract::accuracy
