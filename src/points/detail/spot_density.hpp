// How crowded the place of each spot is.
#pragma once

#include <memory>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "points/cell_grid.hpp"

namespace isoextract::points {

// For each spot the sum of S(distance / support) over all points, itself included, so at least 1: its SPH density in
// units of that of a point by itself. `support` is in grid coordinates. Fails as Context::reserve() does, and where the
// context is cancelled.
[[nodiscard]] Result<std::shared_ptr<ReservedBuffer<float>>> measure_density(const CellGrid& grid, double support,
                                                                             const Context& context,
                                                                             const std::string& label);

}  // namespace isoextract::points
