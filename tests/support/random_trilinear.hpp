// Random samples whose trilinear interpolant has closed surfaces and all kinds of ambiguous cells.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "field/scalar_field.hpp"
#include "support/trilinear_topology.hpp"

namespace isoextract::test {

enum class RandomKind {
  uniform,         // in -1 .. 1
  small_integers,  // -2 .. 2: many samples equal the iso value, and many faces and cells have a saddle of that value
  near_saddle,     // one face or cell has a saddle whose value is 1e-6 .. 1e-2 away from the iso value
};

inline constexpr std::array kRandomKinds{RandomKind::uniform, RandomKind::small_integers, RandomKind::near_saddle};

[[nodiscard]] constexpr std::string_view kind_name(RandomKind kind) {
  return kind == RandomKind::uniform          ? "uniform"
         : kind == RandomKind::small_integers ? "small integers"
                                              : "near saddle";
}

// 5^3 samples, x fastest. The iso value is 0, and boundary samples are below it.
inline constexpr int kRandomSize = 5;

namespace detail {

[[nodiscard]] inline std::size_t random_index(int i, int j, int k) {
  return static_cast<std::size_t>(i + kRandomSize * (j + kRandomSize * k));
}

// Returns the value at the saddle of a cell's interpolant, if it lies in the cell. Finds the point where the gradient
// vanishes by Newton's method.
[[nodiscard]] inline std::optional<double> saddle_value(const std::array<double, 8>& f) {
  const auto value = [&](double x, double y, double z) {
    double sum = 0;
    for (unsigned c = 0; c < 8; ++c) {
      sum += f[c] * ((c & 1) != 0 ? x : 1 - x) * ((c & 2) != 0 ? y : 1 - y) * ((c & 4) != 0 ? z : 1 - z);
    }
    return sum;
  };
  glm::dvec3 p(0.5);
  for (int round = 0; round < 50; ++round) {
    // The interpolant is linear along each axis, so differences across the cell are derivatives.
    const glm::dvec3 g(value(1, p.y, p.z) - value(0, p.y, p.z), value(p.x, 1, p.z) - value(p.x, 0, p.z),
                       value(p.x, p.y, 1) - value(p.x, p.y, 0));
    const double xy = value(1, 1, p.z) - value(1, 0, p.z) - value(0, 1, p.z) + value(0, 0, p.z);
    const double xz = value(1, p.y, 1) - value(1, p.y, 0) - value(0, p.y, 1) + value(0, p.y, 0);
    const double yz = value(p.x, 1, 1) - value(p.x, 1, 0) - value(p.x, 0, 1) + value(p.x, 0, 0);
    const glm::dvec3 step = glm::inverse(glm::dmat3(0, xy, xz, xy, 0, yz, xz, yz, 0)) * g;
    p -= step;
    if (!(glm::length(p) < 10)) return std::nullopt;
    if (glm::length(step) < 1e-14) break;
  }
  const bool within = glm::all(glm::greaterThan(p, glm::dvec3(0))) && glm::all(glm::lessThan(p, glm::dvec3(1)));
  return within ? std::optional(value(p.x, p.y, p.z)) : std::nullopt;
}

}  // namespace detail

[[nodiscard]] inline std::vector<float> random_trilinear(RandomKind kind, std::uint32_t seed) {
  // Does not use std distributions, so that every standard library gives the same fields.
  std::mt19937 engine(seed * 3 + static_cast<std::uint32_t>(kind));
  const auto unit = [&] { return static_cast<double>(engine()) / 4294967296.0; };
  std::vector<float> samples;
  for (int k = 0; k < kRandomSize; ++k) {
    for (int j = 0; j < kRandomSize; ++j) {
      for (int i = 0; i < kRandomSize; ++i) {
        const auto at_data_boundary = [](int n) { return n == 0 || n == kRandomSize - 1; };
        const bool outermost = at_data_boundary(i) || at_data_boundary(j) || at_data_boundary(k);
        double value = outermost ? -1 + 0.999 * unit() : 2 * unit() - 1;
        if (kind == RandomKind::small_integers) {
          value = outermost ? -1 - static_cast<double>(engine() % 2) : static_cast<double>(engine() % 5) - 2;
        }
        samples.push_back(static_cast<float>(value));
      }
    }
  }
  if (kind != RandomKind::near_saddle) return samples;

  const double gap = std::pow(10.0, -2 - 4 * unit()) * (engine() % 2 == 0 ? 1 : -1);
  const auto inner = [&] { return 1 + static_cast<int>(engine() % (kRandomSize - 2)); };
  const bool in_a_face = engine() % 2 == 0;
  for (int attempt = 0; attempt < 200; ++attempt) {
    const int i = static_cast<int>(engine() % (kRandomSize - 1));
    const int j = static_cast<int>(engine() % (kRandomSize - 1));
    const int k = in_a_face ? inner() : static_cast<int>(engine() % (kRandomSize - 1));
    const auto at = [&](int di, int dj, int dk) -> float& {
      return samples[detail::random_index(i + di, j + dj, k + dk)];
    };
    double saddle = 0;
    if (in_a_face) {
      const double a = at(0, 0, 0);
      const double b = at(1, 0, 0);
      const double c = at(0, 1, 0);
      const double d = at(1, 1, 0);
      const bool alternates = (a > 0) == (d > 0) && (b > 0) == (c > 0) && (a > 0) != (b > 0);
      if (!alternates) continue;
      saddle = (a * d - b * c) / (a + d - b - c);
    } else {
      std::array<double, 8> corners;
      for (unsigned c = 0; c < 8; ++c) {
        corners[c] = at(static_cast<int>(c & 1), static_cast<int>(c >> 1 & 1), static_cast<int>(c >> 2 & 1));
      }
      const auto value = detail::saddle_value(corners);
      if (!value) continue;
      saddle = *value;
    }
    for (float& sample : samples) sample = static_cast<float>(sample - saddle + gap);
    break;
  }
  // The shift may have raised boundary samples above iso.
  for (int k = 0; k < kRandomSize; ++k) {
    for (int j = 0; j < kRandomSize; ++j) {
      for (int i = 0; i < kRandomSize; ++i) {
        const auto at_data_boundary = [](int n) { return n == 0 || n == kRandomSize - 1; };
        float& sample = samples[detail::random_index(i, j, k)];
        if ((at_data_boundary(i) || at_data_boundary(j) || at_data_boundary(k)) && !(sample < 0)) sample = -1e-3F;
      }
    }
  }
  return samples;
}

// If samples or saddles equal iso, the surface has two possible topologies. The program's rule for ties gives that of
// the field just above iso; a program that counts iso as inside gives that just below it.
enum class Side { above, below };

// Returns the topology of the surface at iso 0, or just above or below it for small integers, according to the oracle.
// Fields of small integers have no other critical value within 2^-14 of 0.
[[nodiscard]] inline std::optional<SurfaceTopology> true_topology(RandomKind kind, const std::vector<float>& samples,
                                                                  Side side) {
  const double beside = kind == RandomKind::small_integers ? 0x1p-14 : 0.0;
  return TrilinearTopology(samples, kRandomSize, side == Side::above ? beside : -beside)();
}

[[nodiscard]] inline field::ScalarField as_field(std::vector<float> samples) {
  auto owner = std::make_shared<std::vector<float>>(std::move(samples));
  field::ScalarField field;
  field.name = "random";
  field.source = "random field";
  const void* data = owner->data();
  field.samples = field::DenseSamples{field::SampleType::f32, glm::ivec3(kRandomSize), std::move(owner), data};
  return field;
}

}  // namespace isoextract::test
