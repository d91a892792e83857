// For each of many particles those that are near it, as one list after another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "points/cell_grid.hpp"

namespace isoextract::simulate {

class NeighbourLists {
 public:
  // Who is nearer than `reach` to whom. `places` are the particles in the order of the grid's spots, one a spot; the
  // grid's cells are at least `reach` wide. A list is in the order of the spots, without the particle itself.
  // Fails as Context::reserve() does. Memory is kept for the next time.
  [[nodiscard]] Result<void> make(const points::CellGrid& grid, std::span<const glm::dvec3> places, double reach,
                                  const Context& context);

  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t particle) const {
    return {neighbours_.data() + firsts_[particle], firsts_[particle + 1] - firsts_[particle]};
  }

 private:
  Buffer<std::size_t> firsts_;  // one more at the end
  Buffer<std::uint32_t> neighbours_;
  Reservation firsts_memory_;
  Reservation neighbours_memory_;
};

}  // namespace isoextract::simulate
