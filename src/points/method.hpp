// The ways from particles to a field: what they are called, and what each takes where nothing else is asked for.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "base/words.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::points {

enum class Method {
  weight,       // each particle adds a fixed weight to the samples next to it
  sph,          // the interpolation of smoothed particle hydrodynamics, by a cubic spline
  anisotropic,  // the same with a kernel of its own shape for each particle (Yu and Turk 2013)
  spheres,      // the union of the particles' spheres, by OpenVDB
  smooth,       // spheres around averaged positions (Zhu and Bridson 2005), by OpenVDB
};

struct MethodInfo {
  Method method = Method::sph;
  std::string_view id;     // "sph"
  std::string_view title;  // "SPH interpolation"
  std::string_view help;   // how the help lists it
  double iso = 0;          // what is inside: more than this, of a level set less
  double cell_size = 0;    // spacing of the samples, in particle radii
  // A level set is made by whoever has OpenVDB (volume_io/grid_tools.hpp), of what make_spheres() gives; make_field()
  // makes densities.
  field::FieldKind kind = field::FieldKind::density;
};

// In the order of the enum.
//
// weight: a weight of 0.1 each and the iso value 0.15 are those of the seed paper on marching tetrahedra in shaders;
// two particles make a sample inside. So samples are two particle distances apart: eight particles share a cell in the
// liquid. sph: the threshold and the size of the cells are those that splashsurf's documentation suggests. spheres,
// smooth: two voxels a radius leave room above the 1.5 below which a sphere falls between samples (kLeastSphere).
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

// In samples: particles of less radius are left out of level sets.
inline constexpr double kLeastSphere = 1.5;

[[nodiscard]] constexpr const MethodInfo& method_info(Method method) {
  return kMethods[static_cast<std::size_t>(method)];
}

constexpr auto words_of(Method /*type*/) {
  std::array<Word<Method>, kMethods.size()> words{};
  for (std::size_t m = 0; m < words.size(); ++m) words[m] = {kMethods[m].method, kMethods[m].id};
  return words;
}

// Where the weight of a particle goes (Method::weight).
enum class Deposit {
  nearest,    // all of it to the nearest sample; between two of them to the upper one
  trilinear,  // shared among the eight samples around it, as a trilinear interpolant would weigh them
};
constexpr auto words_of(Deposit /*type*/) {
  return std::array{Word{Deposit::nearest, "nearest"}, Word{Deposit::trilinear, "trilinear"}};
}

// Particles whose position is not finite.
enum class BadParticles {
  error,  // ErrorCode::input; the message says which is the first
  skip,   // left out and counted
};
constexpr auto words_of(BadParticles /*type*/) {
  return std::array{Word{BadParticles::error, "error"}, Word{BadParticles::skip, "skip"}};
}

}  // namespace isoextract::points
