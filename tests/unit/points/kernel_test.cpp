// Tests the kernel itself, its vectorized sums, and eigenvectors.
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "points/detail/cubic_spline.hpp"
#include "points/detail/spline_sums.hpp"
#include "points/detail/symmetric_eigen.hpp"

namespace isoextract::points {
namespace {

TEST(CubicSpline, EqualsThePiecewisePolynomial) {
  for (double q = 0; q < 1.5; q += 0.01) {
    const double expected = q <= 0.5 ? 1 - 6 * q * q + 6 * q * q * q : q <= 1 ? 2 * std::pow(1 - q, 3) : 0;
    EXPECT_NEAR(spline_shape(q), expected, 1e-14) << q;
    EXPECT_GE(spline_shape(static_cast<float>(q)), 0) << q;
  }
}

TEST(SymmetricEigen, ReconstructsTheMatrix) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> entry(-1, 1);
  for (int n = 0; n < 200; ++n) {
    glm::dmat3 a(0.0);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) a[i][j] = a[j][i] = entry(engine);
    }
    if (n == 0) a = glm::dmat3(0.0);
    if (n == 1) a = glm::dmat3(2.0);
    if (n == 2) a = glm::outerProduct(glm::dvec3(1, 2, 3), glm::dvec3(1, 2, 3));  // rank 1
    if (n == 3) a = 1e-200 * a;
    const SymmetricEigen eigen = symmetric_eigen(a);
    EXPECT_GE(eigen.values.x, eigen.values.y);
    EXPECT_GE(eigen.values.y, eigen.values.z);
    glm::dmat3 back(0.0);
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
      back += eigen.values[i] * glm::outerProduct(eigen.vectors[i], eigen.vectors[i]);
      for (int j = 0; j < 3; ++j) {
        EXPECT_NEAR(glm::dot(eigen.vectors[i], eigen.vectors[j]), i == j ? 1 : 0, 1e-13);
        largest = std::max(largest, std::abs(a[i][j]));
      }
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(back[i][j], a[i][j], 1e-13 * largest) << n;
    }
  }
}

class SplineSums : public testing::Test {
 protected:
  SplineSums() {
    std::mt19937 engine(11);
    std::uniform_real_distribution<float> coordinate(-1, 2);
    std::uniform_real_distribution<float> positive(0.5F, 3);
    std::uniform_real_distribution<float> mixed(-0.4F, 0.4F);
    balls_->size = 300;
    for (std::size_t n = 0; n < balls_->size; ++n) {
      balls_->x[n] = coordinate(engine);
      balls_->y[n] = coordinate(engine);
      balls_->z[n] = coordinate(engine);
      balls_->weight[n] = positive(engine);
      balls_->xx[n] = positive(engine);
      balls_->yy[n] = positive(engine);
      balls_->zz[n] = positive(engine);
      balls_->xy[n] = mixed(engine);
      balls_->xz[n] = mixed(engine);
      balls_->yz[n] = mixed(engine);
    }
  }

  // Returns the results of all vectorized sums with the instruction sets that Highway may use.
  [[nodiscard]] std::vector<float> all_sums() const {
    std::vector<float> sums;
    for (const float cut : {1.0F, 0.6F}) {
      alignas(64) float values[512] = {};
      add_balls(*balls_, kStep, cut, values);
      sums.insert(sums.end(), values, values + 512);
      std::ranges::fill(values, 0.0F);
      add_ellipsoids(*balls_, kStep, cut, values);
      sums.insert(sums.end(), values, values + 512);
    }
    alignas(64) float at_targets[16] = {};
    add_at_targets(*balls_, balls_->y.data(), balls_->z.data(), balls_->x.data(), 16, at_targets);
    sums.insert(sums.end(), at_targets, at_targets + 16);
    Moments moments;
    add_moments(*balls_, balls_->y.data(), balls_->z.data(), balls_->x.data(), 16, moments);
    for (const auto& sum : moments.sums) sums.insert(sums.end(), sum.begin(), sum.begin() + 16);
    return sums;
  }

  static constexpr float kStep = 0.14F;
  std::unique_ptr<EllipsoidBatch> balls_ = std::make_unique<EllipsoidBatch>();
};

TEST_F(SplineSums, AreBitIdenticalForEveryInstructionSet) {
  const std::vector<float> first = all_sums();
  for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
    const std::int64_t target = targets & -targets;
    hwy::SetSupportedTargetsForTest(target | HWY_SCALAR);
    const std::vector<float> sums = all_sums();
    EXPECT_EQ(std::memcmp(first.data(), sums.data(), first.size() * sizeof(float)), 0) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST_F(SplineSums, EqualSumsOfTheSpline) {
  alignas(64) float balls[512] = {};
  alignas(64) float ellipsoids[512] = {};
  alignas(64) float near[512] = {};
  add_balls(*balls_, kStep, 1, balls);
  add_balls(*balls_, kStep, 0.6F, near);
  add_ellipsoids(*balls_, kStep, 1, ellipsoids);
  for (int v = 0; v < 512; ++v) {
    const glm::dvec3 p = static_cast<double>(kStep) * glm::dvec3(v >> 6, v >> 3 & 7, v & 7);
    double ball_sum = 0;
    double ellipsoid_sum = 0;
    for (std::size_t n = 0; n < balls_->size; ++n) {
      const EllipsoidBatch& b = *balls_;
      const glm::dvec3 d = p - glm::dvec3(b.x[n], b.y[n], b.z[n]);
      const glm::dmat3 form(b.xx[n], b.xy[n], b.xz[n], b.xy[n], b.yy[n], b.yz[n], b.xz[n], b.yz[n], b.zz[n]);
      ball_sum += static_cast<double>(b.weight[n]) * spline_shape(glm::length(d));
      ellipsoid_sum += static_cast<double>(b.weight[n]) * spline_shape(std::sqrt(glm::dot(d, form * d)));
    }
    EXPECT_NEAR(static_cast<double>(balls[v]), ball_sum, 1e-5 * (1 + ball_sum));
    EXPECT_NEAR(static_cast<double>(ellipsoids[v]), ellipsoid_sum, 1e-5 * (1 + ellipsoid_sum));
    EXPECT_LE(near[v], balls[v]);  // exactly: the partial sum omits terms of a sum in the same order
  }
}

}  // namespace
}  // namespace isoextract::points
