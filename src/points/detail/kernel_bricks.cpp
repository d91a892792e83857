#include "points/detail/kernel_bricks.hpp"

#include <algorithm>

#include "points/detail/spline_sums.hpp"

namespace isoextract::points {
namespace {

constexpr int kSampleCount = 512;
// Fraction of a kernel's radius that holds four fifths of the integral of S, in a fifth of the volume.
constexpr float kNearPart = 0.6F;
// Fraction of the iso value: where the sums of near parts are below it, full sums are unlikely to exceed the iso value.
constexpr double kWorthwhile = 0.75;

// Returns an eighth of the median number of spots in a cell, from a sample of the cells. It only selects bricks for a
// proof; no value depends on it.
std::size_t min_interior_spots(const CellGrid& grid) {
  constexpr std::size_t kAsked = 4096;
  std::vector<std::size_t> sizes;
  const std::size_t stride = std::max<std::size_t>(1, grid.cell_count() / kAsked);
  for (std::size_t c = 0; c < grid.cell_count(); c += stride) sizes.push_back(grid.cell_end(c) - grid.cell(c).first);
  if (sizes.empty()) return 1;
  std::ranges::nth_element(sizes, sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2));
  return std::max<std::size_t>(1, sizes[sizes.size() / 2] / 8);
}

// Returns the distance from p to the interval [low, high].
inline double distance_to_interval(double p, double low, double high) {
  return std::max(std::max(low - p, p - high), 0.0);
}

}  // namespace

KernelBricks::KernelBricks(const KernelSet& kernels)
    : kernels_(kernels), min_interior_spots_(min_interior_spots(*kernels.grid)) {}

std::uint64_t KernelBricks::particles_at(std::size_t spot) const {
  return kernels_.counts != nullptr ? kernels_.counts[spot] : kernels_.grid->members(spot).size();
}

template <class F>
void KernelBricks::for_each_near(const glm::ivec3& origin, double part, const F& f) const {
  const glm::dvec3 low(origin);
  const glm::dvec3 high = low + static_cast<double>(field::SparseBlock::kSize - 1);
  const double most = part * kernels_.reach;
  bool goes_on = true;
  kernels_.grid->for_each_spot_run(low - most, high + most, [&](std::size_t first, std::size_t last) {
    for (std::size_t s = first; goes_on && s != last; ++s) {
      const double reach = kernels_.shapes != nullptr ? part * static_cast<double>(kernels_.shapes[s].reach) : most;
      const glm::dvec3& p = kernels_.grid->position(s);
      const double x = distance_to_interval(p.x, low.x, high.x);
      const double y = distance_to_interval(p.y, low.y, high.y);
      const double z = distance_to_interval(p.z, low.z, high.z);
      if (x * x + y * y + z * z < reach * reach) goes_on = f(s);
    }
  });
}

bool KernelBricks::touches(const glm::ivec3& origin) const {
  bool found = false;
  for_each_near(origin, 1, [&](std::size_t) {
    found = true;
    return false;
  });
  return found;
}

void KernelBricks::sum(const glm::ivec3& origin, float part, float* values, const ContributingSpots& marks) const {
  const glm::dvec3 low(origin);
  // Distance between samples, in units where balls have radius 1.
  const double step = kernels_.shapes != nullptr ? 1 : 1 / kernels_.reach;
  EllipsoidBatch batch;
  const auto add = [&] {
    if (kernels_.shapes != nullptr) {
      add_ellipsoids(batch, 1, part, values);
    } else {
      add_balls(batch, static_cast<float>(step), part, values);
    }
    batch.size = 0;
  };
  for_each_near(origin, static_cast<double>(part), [&](std::size_t s) {
    const glm::vec3 p((kernels_.grid->position(s) - low) * step);
    const std::size_t n = batch.size++;
    batch.x[n] = p.x;
    batch.y[n] = p.y;
    batch.z[n] = p.z;
    batch.weight[n] = kernels_.weights[s];
    if (kernels_.shapes != nullptr) {
      const Ellipsoid& shape = kernels_.shapes[s];
      batch.xx[n] = shape.xx;
      batch.xy[n] = shape.xy;
      batch.xz[n] = shape.xz;
      batch.yy[n] = shape.yy;
      batch.yz[n] = shape.yz;
      batch.zz[n] = shape.zz;
    }
    marks.mark(s);
    if (batch.size == kBatch) add();
    return true;
  });
  add();
}

void KernelBricks::fill(const glm::ivec3& origin, float* values, const ContributingSpots& marks) const {
  std::fill_n(values, kSampleCount, 0.0F);
  sum(origin, 1, values, marks);
}

bool KernelBricks::is_probably_inside(const glm::ivec3& origin) const {
  const CellGrid& cells = *kernels_.grid;
  const glm::ivec3 low = cells.cell_at(glm::dvec3(origin));
  const glm::ivec3 high = cells.cell_at(glm::dvec3(origin + (field::SparseBlock::kSize - 1)));
  std::int64_t crowded = 0;
  cells.for_each_run(low, high, [&](std::size_t first, std::size_t last) {
    for (std::size_t c = first; c != last; ++c) {
      crowded += static_cast<std::int64_t>(cells.cell_end(c) - cells.cell(c).first >= min_interior_spots_);
    }
  });
  const glm::i64vec3 dims(high - low + 1);
  return crowded == dims.x * dims.y * dims.z;
}

bool KernelBricks::is_proved_above(const glm::ivec3& origin, double iso) const {
  alignas(64) std::array<float, kSampleCount> values;
  const auto least = [&](float part) {
    values.fill(0);
    sum(origin, part, values.data(), ContributingSpots(nullptr));
    return static_cast<double>(*std::ranges::min_element(values));
  };
  // fill() adds the same numbers in the same order, with further nonnegative ones between them. Rounding is monotone,
  // so each of its sums is at least the sum here, in floating point as well.
  const double near = least(kNearPart);
  return near > iso || (near > kWorthwhile * iso && least(1) > iso);
}

}  // namespace isoextract::points
