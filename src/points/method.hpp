// Methods that turn particles into a field: their names and default parameters.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "base/enum_words.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::points {

enum class Method {
  weight,       // each particle adds a fixed weight to the nearest sample or, shared, to eight samples (Deposit)
  sph,          // interpolation of smoothed particle hydrodynamics with a cubic spline kernel
  anisotropic,  // as sph, with an anisotropic kernel for each particle (Yu and Turk 2013)
  spheres,      // union of the particles' spheres, computed by OpenVDB
  smooth,       // spheres around averaged positions (Zhu and Bridson 2005), computed by OpenVDB
};

struct MethodInfo {
  Method method = Method::sph;
  std::string_view id;     // "sph"
  std::string_view title;  // "SPH interpolation"
  std::string_view help;   // its line in the help
  double iso = 0;          // default iso value; inside is above it; below it for a level set
  double cell_size = 0;    // default spacing of the samples, in particle radii
  // make_field() computes density fields. Level sets are computed by OpenVDB (volume_io/grid_tools.hpp) from the result
  // of make_spheres().
  field::FieldKind kind = field::FieldKind::density;
};

// In the order of the enum. Sources of the defaults:
//
// weight: the weight 0.1 and the iso value 0.15 come from Suravikin and Korobitsyn (docs/papers.md). A cell of 4 radii
// is two particle distances wide, so liquid has eight particles per sample. Samples in the liquid are 0.8, and the
// surface is where the sum falls to the weight of 1.5 particles. sph: splashsurf's documentation suggests this iso
// value and cell size. spheres, smooth: a cell size of 0.5 makes the radius two samples long, above kMinSphereRadius.
inline constexpr std::array kMethods{
    MethodInfo{.method = Method::weight,
               .id = "weight",
               .title = "summed weights",
               .help = "a fixed weight for each particle",
               .iso = 0.15,
               .cell_size = 4},
    MethodInfo{.method = Method::sph,
               .id = "sph",
               .title = "SPH interpolation",
               .help = "SPH interpolation by a cubic spline",
               .iso = 0.6,
               .cell_size = 0.75},
    MethodInfo{.method = Method::anisotropic,
               .id = "anisotropic",
               .title = "anisotropic kernels",
               .help = "SPH interpolation by kernels stretched along the surface (Yu and Turk)",
               .iso = 0.6,
               .cell_size = 0.75},
    MethodInfo{.method = Method::spheres,
               .id = "spheres",
               .title = "united spheres",
               .help = "the distance from the particles' spheres, by OpenVDB",
               .iso = 0,
               .cell_size = 0.5,
               .kind = field::FieldKind::level_set},
    MethodInfo{.method = Method::smooth,
               .id = "smooth",
               .title = "smooth spheres",
               .help = "the distance from spheres around averaged positions (Zhu and Bridson), by OpenVDB",
               .iso = 0,
               .cell_size = 0.5,
               .kind = field::FieldKind::level_set},
};

// Smallest radius in samples: OpenVDB omits smaller particles, as a sphere below 1.5 samples can fall between samples.
inline constexpr double kMinSphereRadius = 1.5;

[[nodiscard]] constexpr const MethodInfo& method_info(Method method) {
  return kMethods[static_cast<std::size_t>(method)];
}

// Returns whether particles have kernels, whose size the smoothing length sets.
[[nodiscard]] constexpr bool has_kernels(Method method) {
  return method != Method::weight && method != Method::spheres;
}

constexpr auto words_of(Method /*type*/) {
  std::array<Word<Method>, kMethods.size()> words{};
  for (std::size_t m = 0; m < words.size(); ++m) words[m] = {kMethods[m].method, kMethods[m].id};
  return words;
}

// How a particle's weight is distributed to samples (Method::weight).
enum class Deposit {
  nearest,    // all of it to the nearest sample; halfway between two, to the upper one
  trilinear,  // to the eight surrounding samples by the weights of trilinear interpolation
};
constexpr auto words_of(Deposit /*type*/) {
  return std::array{Word{Deposit::nearest, "nearest"}, Word{Deposit::trilinear, "trilinear"}};
}

// Treatment of particles with a non-finite position.
enum class NonFiniteParticles {
  error,  // fails with ErrorCode::input; the message names the first one
  skip,   // drops and counts them
};
constexpr auto words_of(NonFiniteParticles /*type*/) {
  return std::array{Word{NonFiniteParticles::error, "error"}, Word{NonFiniteParticles::skip, "skip"}};
}

}  // namespace isoextract::points
