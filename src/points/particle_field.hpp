// Computes a sparse scalar field from particles; its isosurface encloses them.
//
// Inside is value > iso (field::FieldKind::density). Samples are float32 in 8^3 bricks with background 0. Only bricks
// within reach of a particle exist, so memory grows with the particles and not with their bounding box. Positions are
// double and relative to an origin near the particles: a set 1e7 units away from 0 gives the same shape.
//
// Samples lie at world coordinates that are multiples of the spacing, as exactly as double allows. So all frames of a
// sequence with the same spacing share one grid.
//
// In a periodic box (ParticleSet::box), the samples are aligned with the box instead: see ParticleField::region.
// Kernels reach across its faces, and particles outside of it are moved into it by whole periods.
//
// The field is bit-identical for any number of threads and any instruction set.
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

// Parameters of Method::anisotropic; see make_anisotropic_kernels() for the equations.
struct AnisotropyOptions {
  double neighborhood = 2;  // above 0: radius within which neighbors count, in kernel supports
  double lambda = 1;        // 0 to 1: how far a kernel center moves along the normal to the mean of its neighbors
  double shortest = 0.7;    // above 0 and at most 1: shortest axis, in supports
  double widest = 1.8;      // at least 1: length of the axes along a surface, in supports
  double k_n = 0.5;         // above 0 and at most 1: axis length where there are few neighbors, in supports
  int few = 25;             // at least 0 (N_eps); with at most this many neighbors, a kernel is a ball of radius k_n

  friend bool operator==(const AnisotropyOptions&, const AnisotropyOptions&) = default;
};

// Lengths are in world units or in particle radii, as stated. Method::sph follows the conventions of splashsurf (F.
// Loeschner, T. Boettcher, S. R. Jeske, J. Bender: Weighted Laplacian smoothing for surface reconstruction of
// particle-based fluids. VMV 2023, section 3; splashsurf_lib, density_map and kernel). The kernel is a cubic spline
// whose support is twice the smoothing length. The field at x is
//   sum_j m / rho_j W(x - x_j),   rho_j = sum_k m W(x_j - x_k), including the particle itself.
// The field is about 1 within the liquid. The mass m cancels.
struct FieldOptions {
  Method method = Method::sph;
  // Particle radius in world units. Without it, an attribute of kRadiusAttributes (sphere_set.hpp) gives each particle
  // its radius. With Method::sph, the support of a kernel is then proportional to the radius of its particle, and the
  // mass to the cube of the radius. Method::spheres and Method::smooth use the radius of each particle, the other
  // methods the median radius for all. Lengths in radii refer to the median.
  std::optional<double> radius;
  // Particle radius in world units if `radius` is unset and no attribute gives the radii; default suggest_radius().
  std::optional<double> suggested_radius;
  // Takes the place of the median radius of the attribute: for particles that are a part of a larger set.
  std::optional<double> median_radius;
  std::optional<double> cell_size;  // spacing of the samples in radii; default MethodInfo::cell_size
  std::optional<double> spacing;    // spacing in world units, instead of cell_size; only one of them may be set

  double smoothing_length = 2;  // sph, anisotropic, smooth: in radii
  double weight = 0.1;          // weight: contribution of a particle
  Deposit deposit = Deposit::trilinear;
  AnisotropyOptions anisotropy;
  NonFiniteParticles non_finite = NonFiniteParticles::error;

  // For a periodic box: the layers of samples around the region, beyond those that an extraction needs, that store the
  // periodic continuation, so that filters of the field find it there. At least 0.
  int margin = 0;

  // The iso value of the later extraction. If given, a tile of value 1 replaces each brick that is deep inside: all
  // samples of the brick and of its 26 neighbors are proved to be above this iso value. The surface at this iso value
  // stays bit-identical. Do not set it if the field is resampled, coarsened or extracted at another iso value. Has no
  // effect for Method::weight and for iso values of 1 and above.
  std::optional<double> tile_iso;

  friend bool operator==(const FieldOptions&, const FieldOptions&) = default;
};

struct ParticleFieldStatistics {
  std::uint64_t particles = 0;              // particles that contribute to the field
  std::uint64_t particles_dropped = 0;      // particles with a non-finite position (NonFiniteParticles::skip)
  std::uint64_t particles_deep_inside = 0;  // particles too deep inside to reach a stored brick; see tile_iso
  std::uint64_t bricks_stored = 0;
  std::uint64_t inside_tiles = 0;  // tiles that replace bricks
  double radius = 0;               // particle radius in world units; 0 without particles
  bool radius_suggested = false;   // true if it is FieldOptions::suggested_radius or suggest_radius()
  double spacing = 0;              // world units
  double support = 0;              // support of the kernel in world units; 0 for weight and spheres

  std::string radius_attribute;  // name of the attribute of the particles' radii, whose median is `radius`; or empty
  // Particles omitted because their radius is below least_radius: so small that they could fall between samples.
  std::uint64_t particles_too_small = 0;
  double least_radius = kMinSphereRadius;  // in sample spacings; holds only if particles_too_small is above 0
};

struct ParticleField {
  field::ScalarField field;  // has the particles' name and the format "particles"
  // Set for a periodic box: the samples of one period. Along a periodic edge these are the samples from 0 to the number
  // of cells; along other edges the region is unbounded. Sample 0 lies at the origin of the box, and the sample axes
  // are parallel to its edges. The spacing along a periodic edge is adjusted so that a whole number of cells, at least
  // 4, fills it; so the last samples repeat the first ones. Extract only from the cells in this region. Stored samples
  // outside the region have the periodic continuation of the field.
  std::optional<field::IndexBox> region;
  ParticleFieldStatistics figures;
};

// check_options() fails with ErrorCode::usage if an option is out of range; the message names the expected range.
//
// make_field() computes the field of a method whose MethodInfo::kind is density. It fails with ErrorCode::usage for
// another method, if the spacing exceeds the support of the kernel, and as check_options() does. It fails with
// ErrorCode::input
// - if a position is not finite (NonFiniteParticles::error) or there are 2^32 particles or more,
// - if no radius is given and none can be derived,
// - if particles are too far apart or too far from 0 for the spacing,
// - if the field needs 2^31 bricks or more,
// - if a periodic box has too many samples, or kernels reach across it too many times,
// - if the radius is so large that, on average, the cells searched for the neighbors of a particle hold more than
// 32,768
//   particles; if radii differ, the largest kernel decides which cells these are,
// - if a radius of the attribute is negative or not finite.
// It fails with ErrorCode::out_of_memory if memory does not suffice.
// It fails with ErrorCode::cancelled if the context is cancelled.
//
// make_field_and_free() does the same. Without a periodic box, it also frees the positions of the particles once it has
// sorted them, which saves 24 bytes per particle while it sums kernels. It may keep them, for example if it fails.
[[nodiscard]] Result<void> check_options(const FieldOptions& options);
[[nodiscard]] Result<ParticleField> make_field(const ParticleSet& particles, const FieldOptions& options,
                                               const Context& context);
[[nodiscard]] Result<ParticleField> make_field_and_free(ParticleSet& particles, const FieldOptions& options,
                                                        const Context& context);

}  // namespace isoextract::points
