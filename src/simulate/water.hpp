// Water that flows over land, as a cellular automaton on a grid of columns.
//
// The model: "Programma modelirovaniya dvizheniya vody s ispolzovaniem vokselov" (a program that models moving water by
// voxels), report, Bauman Moscow State Technical University, 2019, sections 2.1.2 and 3.3.1.
//
// A cell (x, y) has terrain height T, water depth W and energy E (signed: above 0 it pushes towards +x and +y, below 0
// towards -x and -y). The paper's i is x and its j is y: left is x - 1, right x + 1, back y - 1, front y + 1. A
// neighbor with T', W', E' has the pressure P
//
//   P(left, back) = T' + W' + E'       P(right, front) = T' + W' - E'
//
// Water flows to a side where the cell's own level is above P: flow = min(W, own - P) / flow_div. The neighbor's energy
// becomes E' (1 - friction) - flow to the left and back, + flow to the right and front.
//
// WaterRule::printed is listing 3.3.1 with its signs and order. A cell takes its four pressures and then processes
// left, right, back and front, each on the grid that the previous one changed. A step visits the cells with x in
// the outer and y in the inner loop. The own level is T + W + E towards right and front, T + W - E towards the back.
// Towards the left it is T + W + E in the test but T + W - E in the flow. So if E > 0, a flow to the left can be
// negative: it takes water from the left neighbor even if the neighbor has none, so that the neighbor's depth falls
// below 0. (The last line of the listing, the front neighbor's "+ flow", is lost at the end of a page.)
//
// WaterRule::conservative implements the evident intention of the listing: own levels are T + W - E towards left and
// back, T + W + E towards right and front. Seen from both sides of a face, the driving difference is the same number
// with opposite signs, so water crosses in one direction only. All flows come from the state at the start of the step
// and none is negative. If the four flows of a cell exceed its water, they are scaled down together. A cell adds its
// inflows in a fixed order: W' = W - out + ((left + right) + (back + front)), E' = (1 - friction) E + ((left - right) +
// (back - front)).
//
// Under the conservative rule, the volume of water is conserved up to rounding, and no depth is negative. The water
// comes to rest if flow_div * friction is above 4. The reason: an even lake with energy E passes 2 E / flow_div over
// each face, so a cell gets 4 E / flow_div from its left and back and keeps (1 - friction) E. Depths up to 1e-100 do
// not flow and energies up to 1e-100 become 0, because subnormal numbers slow the arithmetic. The results are bitwise
// equal for any number of threads.
//
// A wall surrounds the grid under both rules. The paper sets the pressure outside to 0, but its listing first tests
// whether a neighbor exists and so never uses it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"

namespace isoextract::simulate {

enum class WaterRule { conservative, printed };
constexpr auto words_of(WaterRule /*type*/) {
  return std::array{Word{WaterRule::conservative, "conservative"}, Word{WaterRule::printed, "printed"}};
}

// A source or drain of water. `rate` is depth per step: a source adds it, a drain removes at most that much.
struct WaterTap {
  glm::ivec2 cell{0};
  double rate = 0;

  friend bool operator==(const WaterTap&, const WaterTap&) = default;
};

inline constexpr double kDefaultFriction = 0.8;
inline constexpr double kDefaultFlowDiv = 6;

struct WaterOptions {
  WaterRule rule = WaterRule::conservative;
  // 0 to 1: the fraction of its energy that a cell loses per step; with the printed rule, per flow that it receives.
  double friction = kDefaultFriction;
  double flow_div = kDefaultFlowDiv;  // 1 or more; from 4 on, the four flows of a cell never exceed its water
  std::vector<WaterTap> sources;
  std::vector<WaterTap> drains;
};

// Volumes of water, in cells.
struct WaterBalance {
  double at_start = 0;
  double poured = 0;
  double drained = 0;
  double there = 0;  // current volume, by a compensated sum

  // Returns the volume error |there - at_start - poured + drained| relative to all water that ever existed, at_start +
  // poured. Returns |there| if there was no water.
  [[nodiscard]] double drift() const;
};

struct WaterExtremes {
  double least_depth = 0;
  double max_depth = 0;
  double most_energy = 0;    // absolute value
  double highest_water = 0;  // terrain plus water, at least 0; counts cells with water above 0 only
  double highest_land = 0;
  std::uint64_t below_zero = 0;  // cells with a negative depth
  bool finite = true;            // false: the other members are meaningless
};

class WaterAutomaton {
 public:
  // Copies `terrain` and `depth` (empty: dry); element x + size.x * y is cell (x, y). Sources act before the flows of a
  // step, drains after them. Fails with ErrorCode::usage if a side is not from 1 to kMaxGridSize (terrain.hpp), if the
  // spans have another length, or if a height or depth is not finite or a depth is negative. Also fails with
  // ErrorCode::usage for options out of range, and for taps outside the grid or with a rate not above 0. Also fails as
  // MemoryBudget::reserve() does.
  [[nodiscard]] static Result<WaterAutomaton> create(glm::ivec2 size, std::span<const double> terrain,
                                                     std::span<const double> depth, WaterOptions options,
                                                     const Context& context);

  // Runs this many steps; each advances the progress by one. Fails with ErrorCode::cancelled between two steps; the
  // steps done so far remain.
  [[nodiscard]] Result<void> run(std::uint64_t steps);

  [[nodiscard]] glm::ivec2 size() const { return size_; }
  [[nodiscard]] std::uint64_t steps_done() const { return steps_done_; }

  // Each returns row y, from 0: size().x heights of the terrain, depths of the water, or energies. The span refers to
  // the automaton's memory; run() changes its values.
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
  void apply_sources();
  void drain();

  glm::ivec2 size_;
  WaterOptions options_;
  Context context_;
  std::shared_ptr<ReservedBuffer<double>> planes_;  // with a rim of one cell: an infinitely high wall
  std::uint64_t steps_done_ = 0;
  double at_start_ = 0;
  std::array<double, 2> poured_{};   // a sum and its rounding error
  std::array<double, 2> drained_{};  // a sum and its rounding error
};

}  // namespace isoextract::simulate
