// One step of the automaton for each of the two rules of water.hpp.
#pragma once

#include <array>
#include <cstddef>

#include <glm/glm.hpp>

namespace isoextract::simulate {

// Values by cell: (x, y) is at x + pitch * y of each plane. A rim of one cell surrounds the grid; there the terrain
// is infinite, and water, energy and flows are 0.
struct WaterPlanes {
  glm::ivec2 size{0};
  std::ptrdiff_t pitch = 0;
  double* terrain = nullptr;
  double* water = nullptr;
  double* energy = nullptr;
  std::array<double*, 4> flows{};  // left, right, back, front; only for the conservative rule
};

// Changes water and energy by one step of WaterRule::printed, cell after cell in one thread.
void printed_step(const WaterPlanes& planes, double friction, double flow_div);
// Changes water, energy and flows by one step of WaterRule::conservative, in parallel.
void conservative_step(const WaterPlanes& planes, double friction, double flow_div);

}  // namespace isoextract::simulate
