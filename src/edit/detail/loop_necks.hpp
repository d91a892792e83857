// Where loops touch, and what they fill hangs together in a point: see loop_triangulation.hpp.
#pragma once

#include <span>

#include <glm/glm.hpp>

#include "edit/detail/hole_bridges.hpp"

namespace isoextract::edit {

// Cuts what the loops of `loops` fill wherever it is joined in a point alone, between points at one place: by edges
// without length there and back, which are listed as bridges. Then each corner has nothing but what is filled in its
// angle. Where edges cross, as rounding may let them, a place is left as it is.
void cut_necks(std::span<const glm::dvec2> points, BridgedLoops& loops);

}  // namespace isoextract::edit
