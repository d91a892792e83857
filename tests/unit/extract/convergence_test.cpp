// Order of convergence, on a sphere of radius 0.7 and a torus (0.6, 0.25) of the demo fields. If the surface follows
// the field, errors of position, area, volume and normals fall with the square of the spacing. Otherwise errors of
// position fall with the spacing.
#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "field/demo_field.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

constexpr double kPi = std::numbers::pi;

struct Truth {
  const char* demo;
  double area;
  double volume;
  double radius;  // the smallest radius of curvature
  std::function<double(glm::dvec3)> distance;
  std::function<glm::dvec3(glm::dvec3)> normal;
};

Truth sphere() {
  constexpr double r = 0.7;
  return {"demo:sphere",
          4 * kPi * r * r,
          4.0 / 3 * kPi * r * r * r,
          r,
          [](glm::dvec3 p) { return glm::length(p) - r; },
          [](glm::dvec3 p) { return glm::normalize(p); }};
}

Truth torus() {
  constexpr double major = 0.6;
  constexpr double minor = 0.25;
  return {"demo:torus",
          4 * kPi * kPi * major * minor,
          2 * kPi * kPi * major * minor * minor,
          minor,
          [](glm::dvec3 p) { return std::hypot(std::hypot(p.x, p.y) - major, p.z) - minor; },
          [](glm::dvec3 p) {
            const double ring = std::hypot(p.x, p.y);
            return glm::normalize(p - glm::dvec3(p.x, p.y, 0) * (major / ring));
          }};
}

struct Errors {
  double position = 0;  // largest distance of a vertex
  double normal = 0;    // largest angle
  double area = 0;
  double volume = 0;
};

Errors measure(const Truth& truth, Method method, int size) {
  const field::ScalarField field =
      field::make_demo_field(std::string(truth.demo) + "?size=" + std::to_string(size), Context()).value();
  ExtractOptions options;
  options.method = method;
  options.smooth_normals = test::traits_of(method).gradient_normals;
  options.output_from_index = field.index_to_world;
  const mesh::Mesh mesh = test::extract(field, options).mesh;
  EXPECT_EQ(mesh.normals.size(), options.smooth_normals ? mesh.positions.size() : 0);
  Errors errors;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3 p = mesh.position(v);
    errors.position = std::max(errors.position, std::abs(truth.distance(p)));
    if (mesh.normals.empty()) continue;
    const glm::dvec3 n(mesh.normals[v]);
    EXPECT_NEAR(glm::length(n), 1, 1e-6);
    errors.normal = std::max(errors.normal, glm::length(glm::cross(n, truth.normal(p))));
    EXPECT_GT(glm::dot(n, truth.normal(p)), 0.9);
  }
  const mesh::MeshSize measured = mesh::measure_size(mesh);
  errors.area = std::abs(measured.area / truth.area - 1);
  errors.volume = std::abs(measured.volume / truth.volume - 1);
  return errors;
}

class Convergence : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, Convergence,
                         testing::ValuesIn(test::methods_with(&MethodTraits::follows_interpolant)), test::method_name);

class FirstOrder : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, FirstOrder,
                         testing::ValuesIn(test::methods_without(&MethodTraits::follows_interpolant)),
                         test::method_name);

TEST_P(Convergence, IsOfSecondOrder) {
  for (const Truth& truth : {sphere(), torus()}) {
    SCOPED_TRACE(truth.demo);
    const Errors coarse = measure(truth, GetParam(), 33);
    const Errors fine = measure(truth, GetParam(), 129);
    const auto order = [](double a, double b) { return std::log2(a / b) / 2; };  // two halvings
    EXPECT_GT(order(coarse.position, fine.position), 1.8);
    if (test::traits_of(GetParam()).gradient_normals) {
      EXPECT_GT(order(coarse.normal, fine.normal), 1.8);
    }
    EXPECT_GT(order(coarse.area, fine.area), 1.8);
    EXPECT_GT(order(coarse.volume, fine.volume), 1.8);
    // The error of a linear crossing is at most (edge length)^2 / (8 radius); the body diagonal is sqrt(3) spacings
    // long.
    const double edge = 2.0 / 128 * (test::traits_of(GetParam()).axis_edges_only ? 1 : std::sqrt(3.0));
    EXPECT_LT(fine.position, edge * edge / (8 * truth.radius) * 1.1);
    EXPECT_LT(fine.volume, 2e-3);
  }
}

// Every vertex lies in a crossed cell, so its error is below the cell size; the errors of the volume mostly cancel out.
TEST_P(FirstOrder, EqualsOrderOfPositions) {
  for (const Truth& truth : {sphere(), torus()}) {
    SCOPED_TRACE(truth.demo);
    for (const int size : {33, 65, 129}) {
      SCOPED_TRACE(size);
      const double spacing = 2.0 / (size - 1);
      const Errors errors = measure(truth, GetParam(), size);
      EXPECT_LT(errors.position, std::sqrt(3.0) * spacing);
      EXPECT_LT(errors.volume, spacing);
    }
  }
}

}  // namespace
}  // namespace isoextract::extract
