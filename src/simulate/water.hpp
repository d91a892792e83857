// Water that flows over land, as a cellular automaton on a grid of columns: "Programma modelirovaniya dvizheniya vody s
// ispolzovaniem vokselov" (a program that models moving water by voxels), report, Bauman Moscow State Technical
// University, 2019, sections 2.1.2 and 3.3.1.
//
// A cell (x, y) has terrain, water (its depth) and energy (signed: above 0 it pushes towards +x and +y, below 0
// towards -x and -y). The paper's i is x, its j is y: left is x - 1, right x + 1, back y - 1, front y + 1. With T, W, E
// of the cell and the side's pressure P
//
//   P(left, back) = T' + W' + E'       P(right, front) = T' + W' - E'       of that neighbour
//
// water goes to a side where the cell's own level is above P: flow = min(W, own - P) / flow_div. The neighbour's energy
// becomes E' (1 - friction) - flow to the left and back, + flow to the right and front.
//
// WaterRule::printed is listing 3.3.1, signs and order as they stand. A cell takes its four pressures, then goes
// through left, right, back, front, each changing the grid that the next one sees; cells follow one another with y
// faster than x (the listing shows one cell of rows i - 1, i, i + 1). The own level is T + W + E towards right and
// front, T + W - E towards the back; towards the left it is T + W + E in the test but T + W - E in the flow. So where E
// > 0 a flow to the left can come out negative: water comes from the left neighbour, whether it has any or not, and its
// depth goes below 0. (The listing's last line, the front neighbour's "+ flow", is lost at the end of a page.)
//
// WaterRule::conservative is what those signs mean: own levels are T + W - E towards left and back, T + W + E towards
// right and front. Then what drives water over a face is the same number with the other sign from the other side, so
// that it crosses in one direction only. All flows come from the state at the start of the step, none is negative, and
// the four of a cell are scaled down together where they are more than its water. A cell gathers what flows in, in one
// order: W' = W - out + ((left + right) + (back + front)), E' = (1 - friction) E + ((left - right) + (back - front)).
// Water is conserved to rounding and never below 0. It comes to rest where flow_div * friction is above 4: an even lake
// that moves by the energy E passes 2 E / flow_div over each face, so that a cell gets 4 E / flow_div from its left and
// back, beside (1 - friction) E of its own. Depths up to 1e-100 do not flow, smaller energies are 0, because numbers
// that halve for ever become slow. The same bits for any number of threads.
//
// The border is a wall under both rules. The paper has pressure 0 outside, but the listing asks first whether there is
// a neighbour, and never uses it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "base/words.hpp"

namespace isoextract::simulate {

enum class WaterRule { conservative, printed };
constexpr auto words_of(WaterRule /*type*/) {
  return std::array{Word{WaterRule::conservative, "conservative"}, Word{WaterRule::printed, "printed"}};
}

// Where water comes in or goes out. Depth a step: a source adds it, a drain takes at most that, as far as there is
// water.
struct Tap {
  glm::ivec2 cell{0};
  double rate = 0;

  friend bool operator==(const Tap&, const Tap&) = default;
};

inline constexpr double kDefaultFriction = 0.8;
inline constexpr double kDefaultFlowDiv = 6;

struct WaterOptions {
  WaterRule rule = WaterRule::conservative;
  double friction = kDefaultFriction;  // 0 to 1: the part of its energy that a cell loses
  double flow_div = kDefaultFlowDiv;   // 1 or more; from 4 on a cell need not scale its flows
  std::vector<Tap> sources;
  std::vector<Tap> drains;
};

// Volumes of water, in cells.
struct WaterBalance {
  double at_start = 0;
  double poured = 0;
  double drained = 0;
  double there = 0;  // now, summed without loss

  // What came from nowhere, relative to all the water that there ever was; 0 where there was none.
  [[nodiscard]] double drift() const;
};

struct WaterExtremes {
  double least_depth = 0;
  double most_depth = 0;
  double most_energy = 0;    // by its absolute value
  double highest_water = 0;  // terrain and water above the floor, of cells with water above 0; 0 where there is none
  double highest_land = 0;
  std::uint64_t below_zero = 0;  // cells
  bool finite = true;            // where not, the other members mean nothing
};

class WaterAutomaton {
 public:
  // Element x + size.x * y of `terrain` and of `depth` (empty: dry) is that of cell (x, y); both are copied. Sources
  // come before the flows of a step, drains after them. Fails with ErrorCode::usage for options outside of what they
  // say, for taps beside the grid or with a rate that is not above 0, and for depths below 0; as
  // MemoryBudget::reserve() does.
  [[nodiscard]] static Result<WaterAutomaton> create(glm::ivec2 size, std::span<const double> terrain,
                                                     std::span<const double> depth, WaterOptions options,
                                                     const Context& context);

  // So many steps more; progress advances by one with each. Fails with ErrorCode::cancelled between two of them.
  [[nodiscard]] Result<void> run(std::uint64_t steps);

  [[nodiscard]] glm::ivec2 size() const { return size_; }
  [[nodiscard]] std::uint64_t steps_done() const { return steps_done_; }

  // Of row y, size().x numbers each.
  [[nodiscard]] std::span<const double> terrain(int y) const { return row(0, y); }
  [[nodiscard]] std::span<const double> water(int y) const { return row(1, y); }
  [[nodiscard]] std::span<const double> energy(int y) const { return row(2, y); }

  [[nodiscard]] WaterBalance balance() const;
  [[nodiscard]] WaterExtremes extremes() const;

 private:
  WaterAutomaton(glm::ivec2 size, WaterOptions options, Context context,
                 std::shared_ptr<ReservedBuffer<double>> planes);

  [[nodiscard]] std::ptrdiff_t pitch() const { return std::ptrdiff_t{size_.x} + 2; }
  [[nodiscard]] double* plane(int which) const;  // at cell (0, 0)
  [[nodiscard]] std::span<const double> row(int which, int y) const;
  void pour();
  void drain();

  glm::ivec2 size_;
  WaterOptions options_;
  Context context_;
  std::shared_ptr<ReservedBuffer<double>> planes_;  // with a border of one cell, a wall without end
  std::uint64_t steps_done_ = 0;
  double at_start_ = 0;
  std::array<double, 2> poured_{};   // a sum and what rounding took from it
  std::array<double, 2> drained_{};  // likewise
};

}  // namespace isoextract::simulate
