// Measures the SPH density at each spot.
#pragma once

#include <memory>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "points/cell_grid.hpp"

namespace isoextract::points {

// Returns for each spot the sum of S(distance / support) over all points including itself, so at least 1: its SPH
// density relative to an isolated point. `support` is in grid coordinates. Fails as Context::reserve() does and if the
// context is cancelled.
[[nodiscard]] Result<std::shared_ptr<ReservedBuffer<float>>> compute_spot_densities(const CellGrid& grid,
                                                                                    double support,
                                                                                    const Context& context,
                                                                                    const std::string& label);

}  // namespace isoextract::points
