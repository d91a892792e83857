#include "mesh/exact_sign.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace isoextract::mesh {
namespace {

__extension__ using Whole = __int128;

int sign_of(Whole value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

// Returns the sign of (b - a) x (c - a) . (d - a).
int whole_side(const std::array<glm::i64vec3, 4>& p) {
  const auto part = [&](int i, int axis) { return Whole{p[static_cast<std::size_t>(i)][axis] - p[0][axis]}; };
  const Whole x = part(1, 1) * part(2, 2) - part(1, 2) * part(2, 1);
  const Whole y = part(1, 2) * part(2, 0) - part(1, 0) * part(2, 2);
  const Whole z = part(1, 0) * part(2, 1) - part(1, 1) * part(2, 0);
  return sign_of(x * part(3, 0) + y * part(3, 1) + z * part(3, 2));
}

int side(const std::array<glm::i64vec3, 4>& p, double scale) {
  std::array<glm::dvec3, 4> d;
  for (std::size_t i = 0; i < 4; ++i) d[i] = glm::dvec3(p[i]) * scale;
  return orientation_3d(d[0], d[1], d[2], d[3]);
}

TEST(ExactSign, DecidesSideOfPlane) {
  EXPECT_EQ(orientation_3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1);
  EXPECT_EQ(orientation_3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}), -1);
  EXPECT_EQ(orientation_3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 7, 0}), 0);
  EXPECT_EQ(orientation_2d({0, 0}, {1, 0}, {0, 1}), 1);
  EXPECT_EQ(orientation_2d({0, 0}, {0, 1}, {1, 0}), -1);
  EXPECT_EQ(orientation_2d({0, 0}, {1, 1}, {3, 3}), 0);
}

// Points on a plane, or off it by one part in 2^22, which the sum in double cannot decide.
TEST(ExactSign, IsExactNearPlane) {
  std::mt19937 random(1);
  std::uniform_int_distribution<std::int64_t> coordinate(-(1 << 11), 1 << 11);
  std::uniform_int_distribution<std::int64_t> factor(-500, 500);
  std::uniform_int_distribution<std::int64_t> off(-1, 1);
  int zeros = 0;
  for (int i = 0; i < 200000; ++i) {
    const auto point = [&] { return glm::i64vec3(coordinate(random), coordinate(random), coordinate(random)); };
    std::array<glm::i64vec3, 4> p{point(), point(), point(), {}};
    p[3] = p[0] + factor(random) * (p[1] - p[0]) + factor(random) * (p[2] - p[0]) +
           glm::i64vec3(off(random), off(random), off(random));
    const int expected = whole_side(p);
    zeros += expected == 0 ? 1 : 0;
    // Powers of two do not change the sign, from subnormal numbers up to the greatest.
    for (const double scale : {1.0, 0x1p-149, 0x1p100}) ASSERT_EQ(side(p, scale), expected) << i;
  }
  EXPECT_GT(zeros, 1000);
}

// Compares with a point moved by too little to change any other sign: (e, e^2, e^3) with e = 2^-7, in units of 2^-21.
TEST(ExactSign, MovesLinesThatMeetApart) {
  std::mt19937 random(4);
  std::uniform_int_distribution<std::int64_t> coordinate(-4, 4);
  const glm::i64vec3 way(3, 2, 1);
  int zeros = 0;
  for (int i = 0; i < 100000; ++i) {
    const auto point = [&] { return glm::i64vec3(coordinate(random), coordinate(random), coordinate(random)); };
    const glm::i64vec3 a = point();
    const glm::i64vec3 b = point();
    const glm::i64vec3 p = point();
    const auto determinant = [&](const glm::i64vec3& u, const glm::i64vec3& v) {
      return way.x * (u.y * v.z - u.z * v.y) + way.y * (u.z * v.x - u.x * v.z) + way.z * (u.x * v.y - u.y * v.x);
    };
    zeros += determinant(a - p, b - p) == 0 ? 1 : 0;
    constexpr std::int64_t kFine = 1 << 21;
    const glm::i64vec3 moved = kFine * p + glm::i64vec3(1 << 14, 1 << 7, 1);
    const int expected = sign_of(determinant(kFine * a - moved, kFine * b - moved));
    for (const double scale : {1.0, 0x1p-149, 0x1p100}) {
      const auto scaled = [&](const glm::i64vec3& v) { return glm::dvec3(v) * scale; };
      ASSERT_EQ(side_of_line(glm::dvec3(way), scaled(a), scaled(b), scaled(p)), expected) << i;
      ASSERT_EQ(side_of_line(glm::dvec3(way), scaled(b), scaled(a), scaled(p)), -expected) << i;
    }
  }
  EXPECT_GT(zeros, 1000);
}

TEST(ExactSign, TurnIsExactNearLine) {
  std::mt19937 random(2);
  std::uniform_int_distribution<std::int64_t> coordinate(-(1 << 12), 1 << 12);
  std::uniform_int_distribution<std::int64_t> factor(-1000, 1000);
  std::uniform_int_distribution<std::int64_t> off(-1, 1);
  for (int i = 0; i < 200000; ++i) {
    const glm::i64vec2 a(coordinate(random), coordinate(random));
    const glm::i64vec2 b(coordinate(random), coordinate(random));
    const glm::i64vec2 c = a + factor(random) * (b - a) + glm::i64vec2(off(random), off(random));
    const int expected = sign_of(Whole{b.x - a.x} * (c.y - a.y) - Whole{b.y - a.y} * (c.x - a.x));
    ASSERT_EQ(orientation_2d(glm::dvec2(a) * 0x1p-149, glm::dvec2(b) * 0x1p-149, glm::dvec2(c) * 0x1p-149), expected);
    ASSERT_EQ(orientation_2d(glm::dvec2(a), glm::dvec2(b), glm::dvec2(c)), expected);
  }
}

// Large and tiny coordinates in one determinant: their difference has more bits than a double.
TEST(ExactSign, KeepsAllBitsOfDistantMagnitudes) {
  const double large = std::numeric_limits<float>::max();
  const double tiny = std::numeric_limits<float>::denorm_min();
  EXPECT_EQ(orientation_3d({large, 0, 0}, {0, large, 0}, {-large, -large, 0}, {0, 0, tiny}), 1);
  EXPECT_EQ(orientation_3d({large, 0, 0}, {0, large, 0}, {-large, -large, 0}, {0, 0, -tiny}), -1);
  EXPECT_EQ(orientation_2d({0, 0}, {large, large}, {tiny, 2 * tiny}), 1);
  EXPECT_EQ(orientation_2d({large, large}, {-large, -large}, {tiny, 0}), 1);
  EXPECT_EQ(orientation_2d({large, large}, {-large, -large}, {0, tiny}), -1);
  EXPECT_EQ(orientation_2d({large, large}, {-large, -large}, {tiny, tiny}), 0);
  EXPECT_TRUE(are_collinear({large, large, large}, {tiny, tiny, tiny}, {0, 0, 0}));
  EXPECT_FALSE(are_collinear({large, large, large}, {tiny, tiny, 0}, {0, 0, 0}));
}

}  // namespace
}  // namespace isoextract::mesh
