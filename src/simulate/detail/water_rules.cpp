#include "simulate/detail/water_rules.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"

namespace isoextract::simulate {
namespace {

constexpr double kThinnestFlow = 1e-100;  // shallower water does not flow
constexpr double kLeastEnergy = 1e-100;   // smaller energies become 0
constexpr int kCellsOfAThread = 1 << 14;  // with fewer cells, threads cost more than they save

template <class Row>
void for_rows(glm::ivec2 size, const Row& row) {
  const int rows = std::max(1, kCellsOfAThread / size.x);
  if (size.y <= rows) {
    for (int y = 0; y < size.y; ++y) row(y);
    return;
  }
  for_each_index(size.y, row, static_cast<std::size_t>(rows));
}

// Computes the outflows of a row's cells. Free of branches, so that it vectorizes.
void compute_outflows_of_row(const WaterPlanes& planes, int y, double part) {
  const std::ptrdiff_t pitch = planes.pitch;
  const double* const __restrict terrain = planes.terrain + pitch * y;
  const double* const __restrict water = planes.water + pitch * y;
  const double* const __restrict energy = planes.energy + pitch * y;
  double* const __restrict to_left = planes.flows[0] + pitch * y;
  double* const __restrict to_right = planes.flows[1] + pitch * y;
  double* const __restrict to_back = planes.flows[2] + pitch * y;
  double* const __restrict to_front = planes.flows[3] + pitch * y;
  for (std::ptrdiff_t x = 0; x < planes.size.x; ++x) {
    const double depth = water[x];
    const double movable = depth > kThinnestFlow ? depth : 0.0;
    const double level = terrain[x] + depth;
    const double push = energy[x];
    const auto flow = [=](double head) { return std::max(std::min(movable, head), 0.0) * part; };
    const auto pressure_before = [=](std::ptrdiff_t at) { return (terrain[at] + water[at]) + energy[at]; };
    const auto pressure_after = [=](std::ptrdiff_t at) { return (terrain[at] + water[at]) - energy[at]; };
    const double left = flow((level - push) - pressure_before(x - 1));
    const double right = flow((level + push) - pressure_after(x + 1));
    const double back = flow((level - push) - pressure_before(x - pitch));
    const double front = flow((level + push) - pressure_after(x + pitch));
    // 1 if the water suffices; the divisor is never 0.
    const double sum = (left + right) + (back + front);
    const double scale = movable / std::max(std::max(sum, movable), std::numeric_limits<double>::min());
    // Rounded parts may sum to more than the whole, so each takes at most what is left.
    double rest = depth;
    const auto take = [&rest](double wanted) {
      const double taken = std::min(wanted, rest);
      rest -= taken;
      return taken;
    };
    to_left[x] = take(left * scale);
    to_right[x] = take(right * scale);
    to_back[x] = take(back * scale);
    to_front[x] = take(front * scale);
  }
}

// Adds the inflows of a row's cells; all outflows must be known.
void gather_inflows_of_row(const WaterPlanes& planes, int y, double kept) {
  const std::ptrdiff_t pitch = planes.pitch;
  double* const __restrict water = planes.water + pitch * y;
  double* const __restrict energy = planes.energy + pitch * y;
  const double* const __restrict to_left = planes.flows[0] + pitch * y;
  const double* const __restrict to_right = planes.flows[1] + pitch * y;
  const double* const __restrict to_back = planes.flows[2] + pitch * y;
  const double* const __restrict to_front = planes.flows[3] + pitch * y;
  for (std::ptrdiff_t x = 0; x < planes.size.x; ++x) {
    const double from_left = to_right[x - 1];
    const double from_right = to_left[x + 1];
    const double from_back = to_front[x - pitch];
    const double from_front = to_back[x + pitch];
    const double rest = (((water[x] - to_left[x]) - to_right[x]) - to_back[x]) - to_front[x];
    water[x] = rest + ((from_left + from_right) + (from_back + from_front));
    const double push = kept * energy[x] + ((from_left - from_right) + (from_back - from_front));
    energy[x] = std::abs(push) > kLeastEnergy ? push : 0.0;
  }
}

}  // namespace

void conservative_step(const WaterPlanes& planes, double friction, double flow_div) {
  const double part = 1 / flow_div;
  for_rows(planes.size, [&](int y) { compute_outflows_of_row(planes, y, part); });
  const double kept = 1 - friction;
  for_rows(planes.size, [&](int y) { gather_inflows_of_row(planes, y, kept); });
}

void printed_step(const WaterPlanes& planes, double friction, double flow_div) {
  const double* const terrain = planes.terrain;
  double* const water = planes.water;
  double* const energy = planes.energy;
  const double kept = 1 - friction;
  for (int i = 0; i < planes.size.x; ++i) {
    for (int j = 0; j < planes.size.y; ++j) {
      const std::ptrdiff_t cell = i + planes.pitch * j;
      const std::ptrdiff_t left = cell - 1;
      const std::ptrdiff_t right = cell + 1;
      const std::ptrdiff_t back = cell - planes.pitch;
      const std::ptrdiff_t front = cell + planes.pitch;
      // Pressures before the first flow. Those in the rim are infinite, so that no level is above them.
      const double left_pressure = terrain[left] + water[left] + energy[left];
      const double right_pressure = terrain[right] + water[right] + -energy[right];
      const double back_pressure = terrain[back] + water[back] + energy[back];
      const double front_pressure = terrain[front] + water[front] + -energy[front];
      // `tested` and `moved` are the signs of the cell's own energy in the test and in the flow.
      const auto pass = [&](std::ptrdiff_t to, double pressure, double tested, double moved, double gain) {
        if (!(terrain[cell] + water[cell] + tested * energy[cell] > pressure)) return;
        const double flow =
            std::min(water[cell], terrain[cell] + water[cell] + moved * energy[cell] + -pressure) / flow_div;
        water[to] += flow;
        water[cell] -= flow;
        energy[to] *= kept;
        energy[to] += gain * flow;
      };
      pass(left, left_pressure, 1, -1, -1);
      pass(right, right_pressure, 1, 1, 1);
      pass(back, back_pressure, -1, -1, -1);
      pass(front, front_pressure, 1, 1, 1);
    }
  }
}

}  // namespace isoextract::simulate
