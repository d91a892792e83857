// The formulas of the demo fields. Evaluated in double they fill samples; evaluated in dual numbers they also give the
// gradient.
//
// Sources: the gyroid, Schoen (1970); the test signal, Marschner and Lobb, "An evaluation of reconstruction filters for
// volume rendering", IEEE Visualization 1994, equations 3 and 4. Dual numbers: forward-mode automatic differentiation,
// Wengert, "A simple automatic derivative evaluation program", Comm. ACM 7, 1964.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

namespace isoextract::field {

// A value and its gradient.
struct Dual {
  double value = 0;
  glm::dvec3 gradient{0.0};

  Dual(double constant) : value(constant) {}  // NOLINT(google-explicit-constructor): formulas mix constants in
  Dual(double v, const glm::dvec3& g) : value(v), gradient(g) {}

  friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.gradient + b.gradient}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.gradient - b.gradient}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.value * b.gradient + b.value * a.gradient};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double quotient = a.value / b.value;
    return {quotient, (a.gradient - quotient * b.gradient) / b.value};
  }
  friend Dual sin(const Dual& a) { return {std::sin(a.value), std::cos(a.value) * a.gradient}; }
  friend Dual cos(const Dual& a) { return {std::cos(a.value), -std::sin(a.value) * a.gradient}; }
  // Gives the gradient 0 at 0, where a distance sqrt(x^2 + ...) has none; 0 is one of its subgradients there.
  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.value);
    return {root, root > 0 ? a.gradient / (2 * root) : glm::dvec3(0)};
  }
  friend Dual hypot(const Dual& a, const Dual& b) {
    const double length = std::hypot(a.value, b.value);
    if (!(length > 0)) return {length, glm::dvec3(0)};
    return {length, (a.value * a.gradient + b.value * b.gradient) / length};
  }
};

namespace formulas {

using std::cos;
using std::hypot;
using std::sin;
using std::sqrt;

inline constexpr double kPi = std::numbers::pi;

inline constexpr double kSphereRadius = 0.7;
inline constexpr double kTorusMajor = 0.6;
inline constexpr double kTorusMinor = 0.25;

struct Sphere {
  template <class S>
  S operator()(const S& x, const S& y, const S& z) const {
    return kSphereRadius - sqrt(x * x + (y * y + z * z));
  }
};

struct Torus {
  template <class S>
  S operator()(const S& x, const S& y, const S& z) const {
    return kTorusMinor - hypot(hypot(x, y) - kTorusMajor, z);
  }
};

// Four periods along each axis.
struct Gyroid {
  static constexpr double kFrequency = 4 * kPi;

  template <class S>
  static S sum(const S& sin_x, const S& cos_x, const S& sin_y, const S& cos_y, const S& sin_z, const S& cos_z) {
    return sin_x * cos_y + sin_y * cos_z + sin_z * cos_x;
  }
  template <class S>
  S operator()(const S& x, const S& y, const S& z) const {
    return sum(sin(kFrequency * x), cos(kFrequency * x), sin(kFrequency * y), cos(kFrequency * y), sin(kFrequency * z),
               cos(kFrequency * z));
  }
};

struct MarschnerLobb {
  static constexpr double kFrequency = 6;
  static constexpr double kAlpha = 0.25;

  template <class S>
  S operator()(const S& x, const S& y, const S& z) const {
    const S ring = cos(2 * kPi * kFrequency * cos(kPi * hypot(x, y) / 2));
    return (1 - sin(kPi * z / 2) + kAlpha * (1 + ring)) / (2 * (1 + kAlpha));
  }
};

struct Metaballs {
  using Balls = std::array<std::array<double, 4>, 5>;  // x, y, z, radius
  static constexpr Balls kBalls{{{-0.35, -0.2, 0.1, 0.35},
                                 {0.3, -0.3, -0.15, 0.3},
                                 {0.1, 0.35, 0.2, 0.32},
                                 {-0.15, 0.1, -0.45, 0.22},
                                 {0.45, 0.2, 0.45, 0.18}}};

  template <class S>
  S operator()(const S& x, const S& y, const S& z) const {
    return blend(kBalls, x, y, z);
  }
  template <class S>
  static S blend(const Balls& balls, const S& x, const S& y, const S& z) {
    S sum = -1;
    for (const auto& [bx, by, bz, radius] : balls) {
      const S d2 = (x - bx) * (x - bx) + (y - by) * (y - by) + (z - bz) * (z - bz);
      sum = sum + radius * radius / (d2 + 0.01);
    }
    return sum;
  }
};

}  // namespace formulas
}  // namespace isoextract::field
