#include "points/detail/anisotropy.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include "points/detail/symmetric_eigen.hpp"

namespace isoextract::points {
namespace {

// Of what (9) gives for a constant density all around, in squares of the radius r.
constexpr double kFullVariance = 0.15;

struct ShapedKernel {
  glm::dvec3 centre;
  float weight;
  Ellipsoid shape;
};

// f(place of the neighbour, members, w_ij), the spot itself included.
template <class F>
void for_each_neighbour(const CellGrid& grid, std::size_t spot, double support, const F& f) {
  const glm::dvec3 p = grid.place(spot);
  const double squared_support = support * support;
  grid.for_each_spot_run(p - support, p + support, [&](std::size_t first, std::size_t last) {
    for (std::size_t s = first; s != last; ++s) {
      const glm::dvec3 away = grid.place(s) - p;
      const double squared = glm::dot(away, away);
      if (squared >= squared_support) continue;
      const double ratio = std::sqrt(squared) / support;
      f(away, grid.members(s).size(), 1 - ratio * ratio * ratio);
    }
  });
}

ShapedKernel shape_of(const CellGrid& grid, std::size_t spot, double support, float density,
                      const AnisotropyOptions& options) {
  // Moments about the spot; the mean is taken off afterwards.
  double total = 0;
  glm::dvec3 first(0);
  glm::dmat3 second(0.0);
  std::size_t points = 0;
  for_each_neighbour(grid, spot, support, [&](const glm::dvec3& away, std::size_t members, double w) {
    const double weight = w * static_cast<double>(members);
    points += members;
    total += weight;
    first += weight * away;
    second += weight * glm::outerProduct(away, away);
  });
  const glm::dvec3 mean = first / total;
  const glm::dmat3 covariance = second / total - glm::outerProduct(mean, mean);
  const SymmetricEigen eigen = symmetric_eigen(covariance);
  glm::dvec3 axes = options.k_s / (kFullVariance * support * support) * eigen.values;
  const std::size_t neighbours = points - grid.members(spot).size();
  if (neighbours <= static_cast<std::size_t>(options.few) || axes.x < options.k_n) {
    axes = glm::dvec3(options.k_n);
  } else {
    axes = glm::max(axes, glm::dvec3(axes.x / options.k_r));
  }
  const glm::dvec3 half = support * axes;
  glm::dmat3 form(0.0);
  for (int n = 0; n < 3; ++n) {
    form += glm::outerProduct(eigen.vectors[n], eigen.vectors[n]) / (half[n] * half[n]);
  }
  ShapedKernel kernel;
  kernel.centre = grid.place(spot) + options.lambda * mean;
  kernel.weight = static_cast<float>(static_cast<double>(grid.members(spot).size()) /
                                     (static_cast<double>(density) * axes.x * axes.y * axes.z));
  kernel.shape = {static_cast<float>(form[0][0]), static_cast<float>(form[1][0]), static_cast<float>(form[2][0]),
                  static_cast<float>(form[1][1]), static_cast<float>(form[2][1]), static_cast<float>(form[2][2]),
                  static_cast<float>(half.x)};
  return kernel;
}

}  // namespace

Result<AnisotropicKernels> make_anisotropic_kernels(const CellGrid& grid, double support, const float* densities,
                                                    const AnisotropyOptions& options, const Context& context,
                                                    const std::string& label) {
  const std::string what = fmt::format("{}: the kernels of {} particles", label, grid.size());
  auto shaped = make_reserved_buffer<ShapedKernel>(grid.size(), context, what);
  if (!shaped) return tl::unexpected(shaped.error());
  auto centres = make_reserved_buffer<glm::dvec3>(grid.size(), context, what);
  if (!centres) return tl::unexpected(centres.error());
  context.progress().begin("shaping kernels", grid.size());
  // Cell by cell, so that neighbours of one are at hand for the next.
  AnisotropicKernels kernels;
  kernels.reach = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, grid.size(), 256), 0.0,
      [&](const auto& range, double reach) {
        if (context.cancelled()) return reach;
        for (std::size_t s = range.begin(); s != range.end(); ++s) {
          const ShapedKernel kernel = shape_of(grid, s, support, densities[s], options);
          (*shaped)->values[s] = kernel;
          (*centres)->values[s] = kernel.centre;
          reach = std::max(reach, static_cast<double>(kernel.shape.reach));
        }
        context.progress().advance(range.size());
        return reach;
      },
      [](double a, double b) { return std::max(a, b); });
  if (auto go_on = context.check(); !go_on) return tl::unexpected(go_on.error());

  auto moved = CellGrid::make(std::as_const((*centres)->values).span(), GridFrame{}, grid.side(),
                              CellGrid::Coinciding::apart, context, label);
  if (!moved) return tl::unexpected(moved.error());
  kernels.grid = std::move(*moved);
  centres->reset();
  auto weights = make_reserved_buffer<float>(grid.size(), context, what);
  if (!weights) return tl::unexpected(weights.error());
  auto shapes = make_reserved_buffer<Ellipsoid>(grid.size(), context, what);
  if (!shapes) return tl::unexpected(shapes.error());
  auto counts = make_reserved_buffer<std::uint32_t>(grid.size(), context, what);
  if (!counts) return tl::unexpected(counts.error());
  for (std::size_t s = 0; s < grid.size(); ++s) {
    const std::size_t from = kernels.grid.members(s)[0];
    (*weights)->values[s] = (*shaped)->values[from].weight;
    (*shapes)->values[s] = (*shaped)->values[from].shape;
    (*counts)->values[s] = static_cast<std::uint32_t>(grid.members(from).size());
  }
  kernels.weights = std::move(*weights);
  kernels.shapes = std::move(*shapes);
  kernels.counts = std::move(*counts);
  return kernels;
}

}  // namespace isoextract::points
