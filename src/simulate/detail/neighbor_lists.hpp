// Lists the neighbors of each particle.
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

class NeighborLists {
 public:
  // Lists for each particle the other particles nearer than `reach`, in spot order. Each spot of `grid` has one
  // particle; positions[s] is the position of the particle at spot s. Grid cells are at least `reach` wide. Keeps
  // memory for the next call. Fails as Context::reserve() does; then the lists are invalid.
  [[nodiscard]] Result<void> make(const points::CellGrid& grid, std::span<const glm::dvec3> positions, double reach,
                                  const Context& context);

  // Returns the spots of the neighbors of the particle at `spot`. Valid until the next make().
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t spot) const { return lists_[spot]; }

 private:
  // The lists of some cells' particles, filled by one thread. Their length is not known beforehand.
  struct Block {
    Buffer<std::uint32_t> neighbors;
    std::size_t used = 0;
    Reservation memory;
    std::optional<Error> error;

    // Grows the buffer, if needed, to hold `count` more neighbors; keeps the content. Returns false and sets `error` if
    // memory cannot be reserved.
    bool make_room(std::size_t count, const Context& context);
  };
  void fill(Block& block, std::size_t first_cell, std::size_t last_cell, const points::CellGrid& grid,
            std::span<const glm::dvec3> positions, double reach, const Context& context);

  std::vector<Block> blocks_;
  Buffer<std::span<const std::uint32_t>> lists_;
  Reservation lists_memory_;
};

}  // namespace isoextract::simulate
