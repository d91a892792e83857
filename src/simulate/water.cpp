#include "simulate/water.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "simulate/detail/water_rules.hpp"
#include "simulate/terrain.hpp"

namespace isoextract::simulate {
namespace {

constexpr int kPlanes = 3;  // terrain, water, energy
constexpr int kPlanesWithFlows = 3 + 4;
constexpr double kWall = std::numeric_limits<double>::infinity();

// Adds to a sum and to its rounding error: A. Neumaier, "Rundungsfehleranalyse einiger Verfahren zur Summation
// endlicher Summen", ZAMM 54, 1974.
void add_compensated(std::array<double, 2>& sum, double value) {
  const double total = sum[0] + value;
  sum[1] += std::abs(sum[0]) >= std::abs(value) ? (sum[0] - total) + value : (value - total) + sum[0];
  sum[0] = total;
}

double value_of_sum(const std::array<double, 2>& sum) { return sum[0] + sum[1]; }

Result<void> check_taps(const std::vector<WaterTap>& taps, glm::ivec2 size, const char* what) {
  for (const WaterTap& tap : taps) {
    if (tap.cell.x < 0 || tap.cell.y < 0 || tap.cell.x >= size.x || tap.cell.y >= size.y) {
      return fail(ErrorCode::usage, fmt::format("a water {}: expected a cell from 0,0 to {},{}, found {},{}", what,
                                                size.x - 1, size.y - 1, tap.cell.x, tap.cell.y));
    }
    if (!(std::isfinite(tap.rate) && tap.rate > 0)) {
      return fail(ErrorCode::usage, fmt::format("a water {}: expected a rate above 0, found {}", what, tap.rate));
    }
  }
  return {};
}

Result<void> check_water(glm::ivec2 size, std::span<const double> terrain, std::span<const double> depth,
                         const WaterOptions& options) {
  if (std::min(size.x, size.y) < 1 || std::max(size.x, size.y) > kMaxGridSize) {
    return fail(ErrorCode::usage, fmt::format("the water grid: expected 1 to {} cells along x and y, found {} x {}",
                                              kMaxGridSize, size.x, size.y));
  }
  const std::size_t cells = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  if (terrain.size() != cells || (!depth.empty() && depth.size() != cells)) {
    return fail(ErrorCode::usage, fmt::format("the water grid: expected a height and a depth for each of {} cells, "
                                              "found {} and {}",
                                              cells, terrain.size(), depth.size()));
  }
  if (!std::ranges::all_of(terrain, [](double height) { return std::isfinite(height); }) ||
      !std::ranges::all_of(depth, [](double value) { return std::isfinite(value) && value >= 0; })) {
    return fail(ErrorCode::usage, "the water grid: expected finite heights, and depths of 0 or more");
  }
  if (!(options.friction >= 0 && options.friction <= 1)) {
    return fail(ErrorCode::usage, fmt::format("the friction of water: expected 0 to 1, found {}", options.friction));
  }
  if (!(std::isfinite(options.flow_div) && options.flow_div >= 1)) {
    return fail(ErrorCode::usage, fmt::format("the flow divisor: expected 1 or more, found {}", options.flow_div));
  }
  TRY(check_taps(options.sources, size, "source"));
  return check_taps(options.drains, size, "drain");
}

}  // namespace

double WaterBalance::drift() const {
  const double ever = at_start + poured;
  return ever > 0 ? std::abs(((there - at_start) - poured) + drained) / ever : std::abs(there);
}

Result<WaterAutomaton> WaterAutomaton::create(glm::ivec2 size, std::span<const double> terrain,
                                              std::span<const double> depth, WaterOptions options,
                                              const Context& context) {
  TRY(check_water(size, terrain, depth, options));
  const auto plane = (static_cast<std::size_t>(size.x) + 2) * (static_cast<std::size_t>(size.y) + 2);
  const std::size_t planes = options.rule == WaterRule::printed ? kPlanes : kPlanesWithFlows;
  auto made = TRY(make_reserved_buffer<double>(planes * plane, context, "the water grid"));
  Buffer<double>& values = made->values;
  std::fill(values.begin(), values.begin() + plane, kWall);
  std::fill(values.begin() + plane, values.end(), 0.0);
  WaterAutomaton water(size, std::move(options), context, std::move(made));
  std::array<double, 2> sum{};
  for (int y = 0; y < size.y; ++y) {
    const std::size_t first = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(y);
    const std::ptrdiff_t at = water.pitch() * y;
    std::copy_n(terrain.begin() + static_cast<std::ptrdiff_t>(first), size.x, water.plane(0) + at);
    if (depth.empty()) continue;
    std::copy_n(depth.begin() + static_cast<std::ptrdiff_t>(first), size.x, water.plane(1) + at);
    for (int x = 0; x < size.x; ++x) add_compensated(sum, depth[first + static_cast<std::size_t>(x)]);
  }
  water.at_start_ = value_of_sum(sum);
  return water;
}

WaterAutomaton::WaterAutomaton(glm::ivec2 size, WaterOptions options, Context context,
                               std::shared_ptr<ReservedBuffer<double>> planes)
    : size_(size), options_(std::move(options)), context_(std::move(context)), planes_(std::move(planes)) {}

double* WaterAutomaton::plane(int which) const {
  const std::ptrdiff_t cells = pitch() * (std::ptrdiff_t{size_.y} + 2);
  return planes_->values.data() + which * cells + pitch() + 1;
}

std::span<const double> WaterAutomaton::row(int which, int y) const {
  return {plane(which) + pitch() * y, static_cast<std::size_t>(size_.x)};
}

void WaterAutomaton::apply_sources() {
  for (const WaterTap& tap : options_.sources) {
    plane(1)[tap.cell.x + pitch() * tap.cell.y] += tap.rate;
    add_compensated(poured_, tap.rate);
  }
}

void WaterAutomaton::drain() {
  for (const WaterTap& tap : options_.drains) {
    double& depth = plane(1)[tap.cell.x + pitch() * tap.cell.y];
    const double taken = std::max(0.0, std::min(tap.rate, depth));
    depth -= taken;
    add_compensated(drained_, taken);
  }
}

Result<void> WaterAutomaton::run(std::uint64_t steps) {
  WaterPlanes planes{size_, pitch(), plane(0), plane(1), plane(2), {}};
  const bool printed = options_.rule == WaterRule::printed;
  for (int side = 0; side < 4 && !printed; ++side) planes.flows[static_cast<std::size_t>(side)] = plane(kPlanes + side);
  const auto step = printed ? printed_step : conservative_step;
  for (std::uint64_t n = 0; n < steps; ++n) {
    TRY(context_.check());
    apply_sources();
    step(planes, options_.friction, options_.flow_div);
    drain();
    ++steps_done_;
    context_.progress().advance(1);
  }
  return {};
}

WaterBalance WaterAutomaton::balance() const {
  std::array<double, 2> sum{};
  for (int y = 0; y < size_.y; ++y) {
    for (const double depth : water(y)) add_compensated(sum, depth);
  }
  return {at_start_, value_of_sum(poured_), value_of_sum(drained_), value_of_sum(sum)};
}

WaterExtremes WaterAutomaton::extremes() const {
  WaterExtremes found{water(0)[0], water(0)[0], 0, 0, terrain(0)[0], 0, true};
  for (int y = 0; y < size_.y; ++y) {
    for (std::size_t x = 0; x < static_cast<std::size_t>(size_.x); ++x) {
      const double depth = water(y)[x];
      const double land = terrain(y)[x];
      found.finite = found.finite && std::isfinite(depth) && std::isfinite(energy(y)[x]);
      found.least_depth = std::min(found.least_depth, depth);
      found.max_depth = std::max(found.max_depth, depth);
      found.most_energy = std::max(found.most_energy, std::abs(energy(y)[x]));
      found.highest_land = std::max(found.highest_land, land);
      if (depth > 0) found.highest_water = std::max(found.highest_water, land + depth);
      if (depth < 0) ++found.below_zero;
    }
  }
  return found;
}

}  // namespace isoextract::simulate
