// Particles as spheres, for methods whose field is the distance from them (MethodInfo::kind).
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "points/particle_field.hpp"
#include "points/particle_set.hpp"

namespace isoextract::points {

// Names of one-component attributes that hold the radius of each particle in world units; the first one found counts.
inline constexpr std::array<std::string_view, 2> kRadiusAttributes{"pscale", "radius"};

[[nodiscard]] bool has_radius_attribute(const ParticleSet& particles);

// Refers to the particle set it was made from, which must outlive it.
class SphereSet {
 public:
  // Returns the particles at finite positions; without attributes if some were dropped. In a periodic box: relative to
  // its origin, moved into the box, without attributes, and followed by images().
  [[nodiscard]] const ParticleSet& particles() const { return kept_ ? *kept_ : *all_; }
  // Returns one radius per particle; empty if all have ParticleFieldStatistics::radius.
  [[nodiscard]] std::span<const float> radii() const { return radii_; }
  // Returns the samples of one period, as ParticleField::region, for a periodic box. Sample 0 lies at the box's origin;
  // the spacing is figures().spacing.
  [[nodiscard]] const std::optional<field::IndexBox>& region() const { return region_; }
  // Returns the origin of the coordinates of particles() in the world.
  [[nodiscard]] const glm::dvec3& origin() const { return origin_; }
  // Returns how many of the last particles are periodic images. Spheres too small to be sampled have none.
  [[nodiscard]] std::uint64_t images() const { return images_; }
  // Returns the figures known before the field exists: the counts of bricks, tiles and too small particles are 0.
  [[nodiscard]] const ParticleFieldStatistics& figures() const { return figures_; }

 private:
  [[nodiscard]] Result<void> repeat(const SimulationBox& box, const FieldOptions& options, const Context& context);

  friend Result<SphereSet> make_spheres(const ParticleSet&, const FieldOptions&, const Context&);
  explicit SphereSet(const ParticleSet& all) : all_(&all) {}

  const ParticleSet* all_;
  std::shared_ptr<const ParticleSet> kept_;  // set if particles were dropped, or the box is periodic
  std::shared_ptr<const ReservedBuffer<float>> kept_radii_;
  std::span<const float> radii_;
  std::optional<field::IndexBox> region_;
  glm::dvec3 origin_{0.0};
  std::uint64_t images_ = 0;
  ParticleFieldStatistics figures_;
};

// Takes the radii from FieldOptions::radius, else from an attribute of kRadiusAttributes, else from the particle
// distances. Lengths given in radii (spacing; for Method::smooth the support, twice the smoothing length) refer to the
// median radius. In a periodic box, the spacing is adjusted so that a whole number of cells fills each periodic edge.
// The result is the same for any number of threads.
//
// Fails with ErrorCode::usage as check_options() does, and if the spacing of Method::smooth exceeds its support. Fails
// with ErrorCode::input if a position is not finite (NonFiniteParticles::error), if there are 2^32 particles or more,
// and if no radius is given and none can be derived. Also fails with ErrorCode::input if a particle at a finite
// position has a radius that is negative or not finite. Fails in the same way if the sample spacing is 0 (the median
// radius is 0), or if spacing or support is not finite. Fails in the same way if the box is periodic and has edges that
// are not parallel to the axes, or periodic edges that are no multiples of one spacing. Fails as Context::reserve() and
// Context::check() do.
[[nodiscard]] Result<SphereSet> make_spheres(const ParticleSet& particles, const FieldOptions& options,
                                             const Context& context);

// Spacings of the samples for spheres of unlike radii, in world units.
struct SphereSpacings {
  double usual = 0;      // MethodInfo::cell_size times the median radius
  double keeps_all = 0;  // the largest spacing that keeps all spheres of a radius above 0; may exceed `usual`
  // The largest spacing, at most `usual`, that keeps all spheres that the spacing usual / kMaxSphereRefinement keeps.
  double keeps_most = 0;
};

// Limits how many times finer than usual samples become for small spheres. A few tiny spheres among many would
// otherwise take all memory: the number of samples grows with the square to the cube of the refinement.
inline constexpr double kMaxSphereRefinement = 4;

// Returns the spacings for radii from an attribute; ignores FieldOptions::cell_size and FieldOptions::spacing. Returns
// nothing if FieldOptions::radius is set, if no attribute gives the radii, or if their median is 0. Fails as
// make_spheres() does for invalid options and radii.
[[nodiscard]] Result<std::optional<SphereSpacings>> find_sphere_spacings(const ParticleSet& particles,
                                                                         const FieldOptions& options,
                                                                         const Context& context);

}  // namespace isoextract::points
