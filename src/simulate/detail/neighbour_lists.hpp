// For each of many particles those that are near it, as a list.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "points/cell_grid.hpp"

namespace isoextract::simulate {

class NeighbourLists {
 public:
  // Who is nearer than `reach` to whom. `places` are the particles in the order of the grid's spots, one a spot; the
  // grid's cells are at least `reach` wide. A list is in the order of the spots, without the particle itself.
  // Fails as Context::reserve() does. Memory is kept for the next time.
  [[nodiscard]] Result<void> make(const points::CellGrid& grid, std::span<const glm::dvec3> places, double reach,
                                  const Context& context);

  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t particle) const { return lists_[particle]; }

 private:
  // The lists of the particles of some cells, filled by one thread: nobody knows beforehand how long they are.
  struct Block {
    Buffer<std::uint32_t> neighbours;
    std::size_t used = 0;
    Reservation memory;
    std::optional<Error> error;

    // Whether there is room for `count` more; what is used stays.
    bool make_room(std::size_t count, const Context& context);
  };
  void fill(Block& block, std::size_t first_cell, std::size_t last_cell, const points::CellGrid& grid,
            std::span<const glm::dvec3> places, double reach, const Context& context);

  std::vector<Block> blocks_;
  Buffer<std::span<const std::uint32_t>> lists_;
  Reservation lists_memory_;
};

}  // namespace isoextract::simulate
