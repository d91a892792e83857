// Splits loops at pinch points, where the filled region touches itself: see loop_triangulation.hpp.
#pragma once

#include <span>

#include <glm/glm.hpp>

#include "edit/detail/hole_bridges.hpp"

namespace isoextract::edit {

// Splits the region that `loops` fill wherever it is connected through a single point. Adds zero-length edges there and
// back between the coincident nodes and lists them as bridges. Afterwards the angle at each corner holds filled region
// only. Leaves a point unchanged if edges cross there because of rounding.
void split_at_pinch_points(std::span<const glm::dvec2> points, BridgedLoops& loops);

}  // namespace isoextract::edit
