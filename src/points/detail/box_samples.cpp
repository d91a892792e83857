#include "points/detail/box_samples.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "points/detail/symmetric_eigen.hpp"

namespace isoextract::points {
namespace {

constexpr double kMinCells = 4;  // so that a cell and its neighbors are different cells
constexpr double kSameStep = 1e-9;

// Returns the common length of three columns at right angles to each other.
std::optional<double> cube_side(const glm::dmat3& steps) {
  const double side = glm::length(steps[0]);
  const glm::dmat3 difference = glm::transpose(steps) * steps - glm::dmat3(side * side);
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (!(std::abs(difference[column][row]) <= kSameStep * side * side)) return std::nullopt;
    }
  }
  return side;
}

}  // namespace

Result<BoxSamples> BoxSamples::make(const SimulationBox& box, double spacing, const std::string& label) {
  BoxSamples samples;
  glm::dmat3 steps(1.0);
  double farthest = 0;
  for (int k = 0; k < 3; ++k) {
    const double length = glm::length(box.edges[k]);
    double cells = length / spacing;
    if (!(cells < field::kMaxSparseIndex / 2.0)) {
      return fail(
          ErrorCode::input,
          fmt::format("{}: an edge of the periodic box is {:.6g} long, more than {} samples at a spacing of {:.6g}",
                      label, length, field::kMaxSparseIndex / 2, spacing),
          {Remedy::raise, Setting::cell_size});
    }
    if (box.periodic[static_cast<std::size_t>(k)]) {
      cells = std::max(kMinCells, std::round(cells));
      samples.cells_[k] = cells;
    }
    steps[k] = box.edges[k] / cells;
    farthest = std::max({farthest, std::abs(box.origin[k]), length});
  }
  if (!(farthest * std::numeric_limits<double>::epsilon() < spacing / 100)) {
    return fail(ErrorCode::input,
                fmt::format("{}: the periodic box is {:.6g} away from 0, where double precision is too coarse for a "
                            "spacing of {:.6g}",
                            label, farthest, spacing),
                {"move the box nearer to 0"});
  }
  samples.world_from_index_ = {steps, box.origin};
  samples.index_from_world_ = glm::inverse(steps);
  samples.cartesian_from_index_ = steps / spacing;
  samples.index_from_cartesian_ = glm::inverse(samples.cartesian_from_index_);
  samples.cubic_step_ = cube_side(samples.cartesian_from_index_);
  const glm::dmat3 rows = glm::transpose(samples.index_from_cartesian_);
  samples.ball_extent_ = {glm::length(rows[0]), glm::length(rows[1]), glm::length(rows[2])};
  samples.longest_stretch_ = std::sqrt(symmetric_eigen(rows * samples.index_from_cartesian_).values.x);
  return samples;
}

glm::dvec3 BoxSamples::wrapped_index(const glm::dvec3& world) const {
  glm::dvec3 index = index_from_world_ * (world - world_from_index_.offset);
  for (int k = 0; k < 3; ++k) {
    if (cells_[k] == 0) continue;
    index[k] -= std::floor(index[k] / cells_[k]) * cells_[k];
    if (index[k] >= cells_[k] || index[k] < 0) index[k] = 0;  // rounding
  }
  return index;
}

std::optional<double> common_spacing(const SimulationBox& box, double spacing) {
  constexpr double kRounding = 1e-6;
  constexpr int kTried = 64;  // numbers of cells on either side of the nearest one
  const auto is_used = [&](int k) { return box.periodic[static_cast<std::size_t>(k)]; };
  const int first = is_used(0) ? 0 : is_used(1) ? 1 : 2;
  const double length = box.edges[first][first];
  const double nearest = std::max(kMinCells, std::round(length / spacing));
  for (int n = 0; n <= 2 * kTried; ++n) {
    const double cells = nearest + (n % 2 == 0 ? n / 2 : -(n + 1) / 2);
    if (cells < kMinCells) continue;
    const double tried = length / cells;
    bool fits = true;
    for (int k = first + 1; k < 3; ++k) {
      const double other = box.edges[k][k] / tried;
      fits = fits && (!is_used(k) || (other > 3.5 && std::abs(other - std::round(other)) < kRounding));
    }
    if (fits) return tried;
  }
  return std::nullopt;
}

field::IndexBox BoxSamples::region() const {
  field::IndexBox region{glm::ivec3(-field::kMaxSparseIndex), glm::ivec3(field::kMaxSparseIndex)};
  for (int k = 0; k < 3; ++k) {
    if (cells_[k] == 0) continue;
    region.min[k] = 0;
    region.max[k] = static_cast<int>(cells_[k]);
  }
  return region;
}

}  // namespace isoextract::points
