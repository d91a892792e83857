// One step of the automaton by each of the two rules of water.hpp.
#pragma once

#include <array>
#include <cstddef>

#include <glm/glm.hpp>

namespace isoextract::simulate {

// Numbers by cell: (x, y) is at x + pitch * y of each plane, and there is a cell more on every side. In that border the
// terrain is infinite, and there is no water, no energy and no flow.
struct WaterPlanes {
  glm::ivec2 size{0};
  std::ptrdiff_t pitch = 0;
  double* terrain = nullptr;
  double* water = nullptr;
  double* energy = nullptr;
  std::array<double*, 4> flows{};  // left, right, back, front; of the conservative rule only
};

void printed_step(const WaterPlanes& planes, double friction, double flow_div);
void conservative_step(const WaterPlanes& planes, double friction, double flow_div);

}  // namespace isoextract::simulate
