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

// Attributes of one number that are the radius of each particle, in world units: the first of them that a set has.
inline constexpr std::array<std::string_view, 2> kRadiusAttributes{"pscale", "radius"};

// Refers to the set that it was made of.
class SphereSet {
 public:
  // Those at finite places.
  [[nodiscard]] const ParticleSet& particles() const { return kept_ ? *kept_ : *all_; }
  // Of each; empty where FieldFigures::radius is that of all.
  [[nodiscard]] std::span<const float> radii() const { return radii_; }
  // Without what the field has to say: bricks, and particles that are too small.
  [[nodiscard]] const FieldFigures& figures() const { return figures_; }

 private:
  friend Result<SphereSet> make_spheres(const ParticleSet&, const FieldOptions&, const Context&);
  explicit SphereSet(const ParticleSet& all) : all_(&all) {}

  const ParticleSet* all_;
  std::shared_ptr<const ParticleSet> kept_;  // where some were dropped
  std::shared_ptr<const ReservedBuffer<float>> kept_radii_;
  std::span<const float> radii_;
  FieldFigures figures_;
};

// Radii are FieldOptions::radius, else those of an attribute of kRadiusAttributes, else suggested by the distances.
// What is in radii (the spacing, and for Method::smooth the support, twice the smoothing length) is in radii of their
// median. Fails as make_field() does, and with ErrorCode::input where an attribute holds what is no radius. The same
// for any number of threads.
[[nodiscard]] Result<SphereSet> make_spheres(const ParticleSet& particles, const FieldOptions& options,
                                             const Context& context);

}  // namespace isoextract::points
