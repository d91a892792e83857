// From particles to a sparse scalar field whose isosurface wraps them.
//
// Inside is value > iso (field::FieldKind::density). Samples are float32 in 8^3 bricks, background 0, and only bricks
// that a particle reaches are there: memory follows the particles and not the box around them. Positions are double and
// are taken relative to an origin near the particles, so a set that is 1e7 units away from 0 gives the same shape.
//
// Samples lie at multiples of the spacing from the world's 0, as exactly as double allows: frames of a sequence with
// one spacing share one grid.
//
// The field is the same bit by bit for any number of threads and any instruction set.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "points/method.hpp"
#include "points/particle_set.hpp"

namespace isoextract::points {

// For Method::anisotropic. The names are those of Yu and Turk; see make_anisotropic_kernels() for the equations.
struct AnisotropyOptions {
  double neighbourhood = 2;  // above 0: radius within which neighbours count, in supports
  double lambda = 0.9;       // 0 to 1: how far centres move towards the mean of their neighbours
  double k_r = 4;            // at least 1: how many times as long as another an axis can be
  double k_s = 1;            // above 0: length of the axes where there are particles all around, in supports
  double k_n = 0.5;          // above 0: length of the axes where there are few, in supports
  int few = 25;              // N_eps: no more neighbours than this are few

  friend bool operator==(const AnisotropyOptions&, const AnisotropyOptions&) = default;
};

// Lengths are in world units or in particle radii, as said. Method::sph follows the conventions of splashsurf
// (F. Loeschner, T. Boettcher, S. R. Jeske, J. Bender: Weighted Laplacian smoothing for surface reconstruction of
// particle-based fluids. VMV 2023, section 3; splashsurf_lib, density_map and kernel): the kernel is a cubic spline
// whose support is twice the smoothing length, and the field at x is
//   sum_j m / rho_j W(x - x_j),   rho_j = sum_k m W(x_j - x_k), the particle itself included,
// which is about 1 within the liquid. A particle's mass m, there that of a cube of liquid two radii wide, drops out.
struct FieldOptions {
  Method method = Method::sph;
  std::optional<double> radius;     // of a particle, world units; else ParticleStatistics::suggested_radius()
  std::optional<double> cell_size;  // spacing of the samples in radii; else MethodInfo::cell_size
  std::optional<double> spacing;    // in place of cell_size, in world units

  double smoothing_length = 2;  // sph, anisotropic, smooth: in radii
  double weight = 0.1;          // weight: what a particle adds
  Deposit deposit = Deposit::trilinear;
  AnisotropyOptions anisotropy;
  BadParticles bad = BadParticles::error;

  // The iso value that will be extracted on these very samples. Where it is given, bricks that are proved to be farther
  // inside than the extraction looks are left out: only tiles of the value 1 say that they are inside. The surface at
  // this iso value stays the same bit by bit. Not for a field that is resampled, made coarser, or extracted at another
  // value. weight leaves nothing out, nor is anything left out for 1 and more.
  std::optional<double> leave_out_inside;

  friend bool operator==(const FieldOptions&, const FieldOptions&) = default;
};

struct FieldFigures {
  std::uint64_t particles = 0;           // that made the field
  std::uint64_t particles_dropped = 0;   // not finite (BadParticles::skip)
  std::uint64_t particles_left_out = 0;  // so deep inside that no stored brick has them; where some were left out
  std::uint64_t bricks_stored = 0;
  std::uint64_t bricks_inside = 0;  // tiles in place of bricks
  double radius = 0;                // what was taken, world units; 0 where there are no particles
  bool radius_suggested = false;    // by the distances of the particles
  double spacing = 0;               // world units
  double support = 0;               // of the kernel, world units; 0 for weight and spheres

  // Of level sets alone.
  std::string radius_attribute;           // that gave each particle its own; `radius` is the median of them
  std::uint64_t particles_too_small = 0;  // left out: of less radius than kLeastSphere samples
};

struct ParticleField {
  field::ScalarField field;  // named like the particles, its format "particles"
  FieldFigures figures;
};

// Fails with ErrorCode::usage where options make no sense, naming what is expected. With ErrorCode::input where a
// position is not finite (BadParticles::error), where the particles do not say their radius, where they are too far
// apart or too far away for the spacing, and where the memory is not there. With ErrorCode::cancelled. make_field()
// makes the densities of method.hpp; other methods are ErrorCode::usage.
[[nodiscard]] Result<void> check_options(const FieldOptions& options);
[[nodiscard]] Result<ParticleField> make_field(const ParticleSet& particles, const FieldOptions& options,
                                               const Context& context);

}  // namespace isoextract::points
