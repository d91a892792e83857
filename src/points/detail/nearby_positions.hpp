// Finds the nearest positions of each particle, across the faces of a periodic box as well.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "points/detail/nearest_tree.hpp"
#include "points/particle_set.hpp"

namespace isoextract::points {

class NearbyPositions {
 public:
  // `particles` must outlive the result. Fails with ErrorCode::input for 2^32 particles or more, and as
  // Context::reserve() and Context::check() do.
  [[nodiscard]] static Result<NearbyPositions> make(const ParticleSet& particles, const Context& context);

  [[nodiscard]] std::size_t size() const { return positions_.size(); }
  // Returns whether the particle's position is finite.
  [[nodiscard]] bool has_position(std::size_t particle) const;

  // Sets `offsets` to the vectors from a particle at a finite position to the nearest positions, at most `count`, in
  // order of distance. In a periodic box, includes positions of images, also of images of the particle itself.
  // Coincident positions count once. The position of the particle itself does not count.
  void find(std::size_t particle, std::size_t count, std::vector<glm::dvec3>& offsets) const;

 private:
  // Adds the positions around `from`, a position shifted by periods. `offsets` stay sorted, at most `count`.
  void add_around(const glm::dvec3& from, std::size_t count, std::vector<glm::dvec3>& offsets) const;

  std::span<const glm::dvec3> positions_;                      // in the periodic box
  std::shared_ptr<const ReservedBuffer<glm::dvec3>> wrapped_;  // null without a periodic box
  NearestTree tree_;
  std::array<bool, 3> periodic_{false, false, false};
  glm::dmat3 edges_{1.0};
  glm::dvec3 heights_{1.0};  // distances of opposite faces of the box
  double rounding_ = 0;      // positions this near to each other coincide
};

}  // namespace isoextract::points
