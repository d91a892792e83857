#include "field/interpolant.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "support/fields.hpp"

namespace isoextract::field {
namespace {

std::vector<glm::dvec3> random_points(const glm::dvec3& size) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 200; ++i) points.push_back(size * glm::dvec3(unit(engine), unit(engine), unit(engine)));
  return points;
}

// Trilinear interpolation is exact for functions that are linear along each axis, including products.
TEST(Interpolant, TrilinearIsExactForTrilinearFields) {
  const auto f = [](double x, double y, double z) { return 1 + 2 * x - y + 0.5 * z + x * y * z - 3 * y * z; };
  const ScalarField field = test::dense_field<double>({4, 5, 6}, f);
  const Interpolant interpolant(field, Interpolation::trilinear);
  Interpolant::Cursor at(interpolant);
  for (const glm::dvec3& p : random_points({3, 4, 5})) {
    const Interpolated found = at(p);
    EXPECT_NEAR(found.value, f(p.x, p.y, p.z), 1e-12);
    EXPECT_NEAR(found.gradient.x, 2 + p.y * p.z, 1e-12);
    EXPECT_NEAR(found.gradient.y, -1 + p.x * p.z - 3 * p.z, 1e-12);
    EXPECT_NEAR(found.gradient.z, 0.5 + p.x * p.y - 3 * p.y, 1e-12);
  }
}

// Central differences are exact for a parabola, and so are the one-sided ones at the boundary.
TEST(Interpolant, TricubicIsExactForParabolasUpToBoundary) {
  const auto f = [](double x, double y, double z) { return x * x * (1 + y) - 2 * y * y * z + 0.5 * z * z - x; };
  for (const glm::ivec3& dims : {glm::ivec3(3, 4, 6), glm::ivec3(7, 3, 5)}) {
    const ScalarField field = test::dense_field<double>(dims, f);
    const Interpolant interpolant(field, Interpolation::tricubic);
    Interpolant::Cursor at(interpolant);
    for (const glm::dvec3& p : random_points(glm::dvec3(dims - 1))) {
      const Interpolated found = at(p);
      EXPECT_NEAR(found.value, f(p.x, p.y, p.z), 1e-11);
      EXPECT_NEAR(found.gradient.x, 2 * p.x * (1 + p.y) - 1, 1e-11);
      EXPECT_NEAR(found.gradient.y, p.x * p.x - 4 * p.y * p.z, 1e-11);
      EXPECT_NEAR(found.gradient.z, -2 * p.y * p.y + p.z, 1e-11);
    }
  }
}

TEST(Interpolant, TricubicIsLinearWithTwoSamples) {
  const ScalarField field = test::dense_field<float>({2, 2, 5}, [](int i, int j, int k) { return i + 2 * j + k * k; });
  const Interpolant interpolant(field, Interpolation::tricubic);
  Interpolant::Cursor at(interpolant);
  const Interpolated found = at({0.25, 0.5, 1.5});
  EXPECT_NEAR(found.value, 0.25 + 1 + 2.25, 1e-12);
  EXPECT_NEAR(glm::length(found.gradient - glm::dvec3(1, 2, 3)), 0, 1e-12);
}

// At the face between two cells the tricubic gradient is the same from both sides, the trilinear one is not.
TEST(Interpolant, TricubicIsSmoothAcrossCells) {
  const ScalarField field = test::random_field<double>({6, 6, 6}, 3, 1000);
  for (const auto& [interpolation, smooth] :
       {std::pair(Interpolation::tricubic, true), {Interpolation::trilinear, false}}) {
    const Interpolant interpolant(field, interpolation);
    Interpolant::Cursor at(interpolant);
    const Interpolated left = at({2 - 1e-12, 2.4, 3.7});
    const Interpolated right = at({2, 2.4, 3.7});
    EXPECT_NEAR(left.value, right.value, 1e-6);
    EXPECT_EQ(glm::length(left.gradient - right.gradient) < 1e-6, smooth);
    const double step = 1e-6;
    const glm::dvec3 p(3.3, 2.4, 1.7);
    const Interpolated here = at(p);
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 d(0);
      d[axis] = step;
      EXPECT_NEAR((at(p + d).value - at(p - d).value) / (2 * step), here.gradient[axis], 1e-4);
    }
  }
}

TEST(Interpolant, SparseEqualsDenseForEveryType) {
  for (const SampleType type : {SampleType::u8, SampleType::i8, SampleType::u16, SampleType::i16, SampleType::u32,
                                SampleType::i32, SampleType::f16, SampleType::f32, SampleType::f64}) {
    visit_sample_type(type, [&]<class T>(std::type_identity<T>) {
      ScalarField dense = test::dense_field<T>({24, 24, 24}, [](int i, int j, int k) {
        return i < 8 && j < 16 ? 5 : (i * 7 + j * 3 + k * 11) % 100;  // some blocks are constant
      });
      dense.scale = {-2, 10};
      const ScalarField sparse = test::sparse_copy<T>(dense, 0);
      ASSERT_FALSE(std::get<SparseSamples>(sparse.samples).tiles.empty());
      for (const Interpolation interpolation : {Interpolation::trilinear, Interpolation::tricubic}) {
        const Interpolant of_dense(dense, interpolation);
        const Interpolant of_sparse(sparse, interpolation);
        Interpolant::Cursor at_dense(of_dense);
        Interpolant::Cursor at_sparse(of_sparse);
        for (const glm::dvec3& p : random_points({20, 20, 20})) {
          const glm::dvec3 inner = p + 1.0;
          EXPECT_EQ(at_dense(inner).value, at_sparse(inner).value);
          EXPECT_EQ(at_dense(inner).gradient, at_sparse(inner).gradient);
        }
        EXPECT_EQ(at_sparse({-50.5, 3, 3}).value, 10) << "the background, with the scale";
        EXPECT_EQ(at_dense({3, 4, 5}).value, -2 * 5 + 10);
      }
    });
  }
}

TEST(Interpolant, IsNanBesideNonFiniteSamples) {
  const ScalarField field = test::dense_field<float>({6, 6, 6}, [](int i, int j, int k) {
    return glm::ivec3(i, j, k) == glm::ivec3(3, 3, 3) ? test::kNaN
           : glm::ivec3(i, j, k) == glm::ivec3(0)     ? -INFINITY
                                                      : 1.0;
  });
  const Interpolant linear(field, Interpolation::trilinear);
  const Interpolant cubic(field, Interpolation::tricubic);
  Interpolant::Cursor at_linear(linear);
  Interpolant::Cursor at_cubic(cubic);
  EXPECT_TRUE(std::isnan(at_linear({2.5, 2.5, 2.5}).value));
  EXPECT_TRUE(std::isnan(at_linear({0.5, 0.5, 0.5}).value));
  EXPECT_EQ(at_linear({1.5, 1.5, 1.5}).value, 1);
  EXPECT_TRUE(std::isnan(at_cubic({1.5, 1.5, 1.5}).value)) << "its stencil is wider";
  EXPECT_EQ(at_cubic({4.5, 4.5, 0.5}).value, 1);
}

// On a face the polynomials of both cells give the same bits.
TEST(Interpolant, CellsAgreeOnSharedFaces) {
  const ScalarField field = test::random_field<std::uint8_t>({5, 5, 5}, 3, 256);
  for (const Interpolation interpolation : {Interpolation::trilinear, Interpolation::tricubic}) {
    const Interpolant interpolant(field, interpolation);
    Interpolant::Cursor one(interpolant);
    Interpolant::Cursor other(interpolant);
    for (int step = 0; step <= 10; ++step) {
      const double t = step / 10.0;
      EXPECT_EQ(one.evaluate_in_cell({1, 2, 1}, {1, t, 0.3}).value,
                other.evaluate_in_cell({2, 2, 1}, {0, t, 0.3}).value);
      EXPECT_EQ(one.evaluate_in_cell({1, 2, 1}, {t, 0.7, 1}).value,
                other.evaluate_in_cell({1, 2, 2}, {t, 0.7, 0}).value);
    }
  }
}

TEST(Interpolant, CellReturnsRangeAndGreatestBend) {
  const ScalarField field = test::dense_field<double>({3, 3, 3}, [](int i, int j, int k) {
    return i == 2 && j == 2 && k == 2 ? std::numeric_limits<double>::quiet_NaN() : 1 + 3 * i * j - 2 * j * k;
  });
  const Interpolant interpolant(field, Interpolation::trilinear);
  Interpolant::Cursor at(interpolant);
  const auto range = at.range({0, 0, 0});
  ASSERT_TRUE(range);
  EXPECT_EQ(range->low, -1);
  EXPECT_EQ(range->high, 4);
  EXPECT_NEAR(at.max_second_derivative({0, 0, 0}).value(), std::sqrt(2.0 * (9 + 4)), 1e-12);
  EXPECT_FALSE(at.range({1, 1, 1}));
  EXPECT_FALSE(at.max_second_derivative({1, 1, 1}));
}

TEST(Interpolant, ReturnsNanAtNan) {
  const ScalarField dense = test::random_field<float>({8, 8, 8}, 1, 10);
  for (const ScalarField& field : {dense, test::sparse_copy<float>(dense, 0)}) {
    const Interpolant interpolant(field, Interpolation::trilinear);
    const glm::dvec3 position(2.5, test::kNaN, 3.5);
    const bool is_dense = std::holds_alternative<DenseSamples>(field.samples);
    EXPECT_EQ(interpolant.cell_of(position), glm::ivec3(2, is_dense ? 0 : -kMaxSparseIndex, 3));
    EXPECT_TRUE(std::isnan(Interpolant::Cursor(interpolant)(position).value));
  }
}

}  // namespace
}  // namespace isoextract::field
