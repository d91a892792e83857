#include "points/detail/ball_kernels.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "points/detail/cubic_spline.hpp"

namespace isoextract::points {

Result<LargeEnough> leave_out_small(std::span<const glm::dvec3> positions, std::span<const float> radii,
                                    double smallest, const Context& context, const std::string& label) {
  LargeEnough kept;
  kept.positions = TRY(make_reserved_buffer<glm::dvec3>(positions.size(), context, label + ": positions of particles"));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const bool is_kept = static_cast<double>(radii[i]) >= smallest;
    kept.positions->values[i] = is_kept ? positions[i] : glm::dvec3(std::numeric_limits<double>::quiet_NaN());
    kept.too_small +=
        static_cast<std::uint64_t>(!is_kept && std::isfinite(positions[i].x + positions[i].y + positions[i].z));
  }
  return kept;
}

Result<BallKernels> BallKernels::make(const CellGrid& grid, std::span<const float> radii, double support, double reach,
                                      const Context& context, const std::string& label) {
  BallKernels kernels;
  kernels.grid_ = &grid;
  kernels.reach_ = reach;
  const std::string what = fmt::format("{}: the kernels of {} particles", label, grid.size());
  kernels.weights_ = TRY(make_reserved_buffer<float>(grid.size(), context, what));
  kernels.shapes_ = TRY(make_reserved_buffer<Ellipsoid>(grid.size(), context, what));
  const auto radius_of = [&](std::size_t spot) { return static_cast<double>(radii[grid.members(spot).front()]); };
  context.progress().begin("measuring densities", grid.size());
  for_each_range(grid.size(), 1024, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (std::size_t s = begin; s != end; ++s) {
      const glm::dvec3& p = grid.position(s);
      double density = 0;
      grid.for_each_spot_run(p - reach, p + reach, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k != last; ++k) {
          const glm::dvec3 away = grid.position(k) - p;
          const double squared = glm::dot(away, away);
          const double other = support * radius_of(k);
          if (squared < other * other) density += spline_shape(std::sqrt(squared) / other);
        }
      });
      const double own = support * radius_of(s);
      const auto entry = static_cast<float>(1 / (own * own));
      kernels.weights_->values[s] = static_cast<float>(1 / density);
      kernels.shapes_->values[s] = {entry, 0, 0, entry, 0, entry, static_cast<float>(own)};
    }
    context.progress().advance(end - begin);
  });
  TRY(context.check());
  return kernels;
}

}  // namespace isoextract::points
