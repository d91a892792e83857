#include "field/analytic_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "field/demo_field.hpp"

namespace isoextract::field {
namespace {

using formulas::kPi;

template <class Formula>
double formula_value(const glm::dvec3& p) {
  return Formula{}(p.x, p.y, p.z);
}

template <class Formula>
Dual dual_of(const glm::dvec3& p) {
  return Formula{}(Dual(p.x, {1, 0, 0}), Dual(p.y, {0, 1, 0}), Dual(p.z, {0, 0, 1}));
}

std::optional<SurfaceSize> sphere_size(double iso) {
  const double radius = formulas::kSphereRadius - iso;
  if (!(radius > 0 && radius < 1)) return std::nullopt;
  return SurfaceSize{4 * kPi * radius * radius, 4.0 / 3 * kPi * radius * radius * radius};
}

std::optional<SurfaceSize> torus_size(double iso) {
  constexpr double kMajor = formulas::kTorusMajor;
  const double minor = formulas::kTorusMinor - iso;
  if (!(minor > 0 && minor < kMajor && kMajor + minor < 1)) return std::nullopt;
  return SurfaceSize{4 * kPi * kPi * kMajor * minor, 2 * kPi * kPi * kMajor * minor * minor};
}

// Along z the gyroid is c + a sin(kFrequency z + phase), over whole periods.
double gyroid_length(double x, double y, double iso) {
  constexpr double kFrequency = formulas::Gyroid::kFrequency;
  const double c = std::sin(kFrequency * x) * std::cos(kFrequency * y);
  const double a = std::hypot(std::sin(kFrequency * y), std::cos(kFrequency * x));
  return 2 * std::acos(std::clamp((iso - c) / a, -1.0, 1.0)) / kPi;
}

// The signal decreases along z by sin(pi z / 2) / (2 (1 + alpha)).
double marschner_lobb_length(double x, double y, double iso) {
  const double at_0 = formulas::MarschnerLobb{}(x, y, 0.0);
  const double sine = 2 * (1 + formulas::MarschnerLobb::kAlpha) * (at_0 - iso);
  return 1 + std::asin(std::clamp(sine, -1.0, 1.0)) * 2 / kPi;
}

std::optional<SurfaceSize> unknown_size(double) { return std::nullopt; }

constexpr std::array kFields{
    AnalyticField{"sphere", formula_value<formulas::Sphere>, dual_of<formulas::Sphere>, true, sphere_size, nullptr,
                  false},
    AnalyticField{"torus", formula_value<formulas::Torus>, dual_of<formulas::Torus>, true, torus_size, nullptr, false},
    AnalyticField{"gyroid", formula_value<formulas::Gyroid>, dual_of<formulas::Gyroid>, false, unknown_size,
                  gyroid_length, false},
    AnalyticField{"marschner-lobb", formula_value<formulas::MarschnerLobb>, dual_of<formulas::MarschnerLobb>, false,
                  unknown_size, marschner_lobb_length, true},
    AnalyticField{"metaballs", formula_value<formulas::Metaballs>, dual_of<formulas::Metaballs>, false, unknown_size,
                  nullptr, false},
};

}  // namespace

const AnalyticField* find_analytic_field(std::string_view demo_name) {
  const auto* const found = std::ranges::find(kFields, demo_name, &AnalyticField::name);
  return found == kFields.end() ? nullptr : found;
}

const AnalyticField* find_formula(const ScalarField& field) {
  if (field.format != "demo") return nullptr;
  const auto spec = parse_demo_spec(field.source);
  return spec && spec->time == 0 ? find_analytic_field(field.name) : nullptr;
}

}  // namespace isoextract::field
