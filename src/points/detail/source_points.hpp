// The particles whose kernels may reach a position: all particles and, in a periodic box, their images.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "points/detail/box_samples.hpp"
#include "points/detail/periodic_images.hpp"
#include "points/particle_set.hpp"

namespace isoextract::points {

// Refers to the particle set, which must outlive it.
class SourcePoints {
 public:
  // `support` is the reach of a kernel in world units. In a periodic box the points have other coordinates than the
  // world. Fails as BoxSamples::make() and with_images() do.
  [[nodiscard]] static Result<SourcePoints> make(const ParticleSet& particles, double support, const Context& context);

  // Returns the positions of the particles in their order, followed by the positions of images.
  [[nodiscard]] std::span<const glm::dvec3> positions() const { return positions_; }
  // Returns the support of the kernels in the coordinates of the positions.
  [[nodiscard]] double support() const { return support_; }
  // Returns the index of a point's particle.
  [[nodiscard]] std::size_t particle(std::size_t point) const {
    return images_ ? images_->sources->values[point] : point;
  }
  // Returns a world position in the coordinates of the positions.
  [[nodiscard]] glm::dvec3 place_of(const glm::dvec3& position) const {
    return box_ ? box_->cartesian_from_index() * box_->wrapped_index(position) : position;
  }

 private:
  std::span<const glm::dvec3> positions_;
  double support_ = 0;
  std::optional<BoxSamples> box_;
  std::optional<ParticleImages> images_;
};

}  // namespace isoextract::points
