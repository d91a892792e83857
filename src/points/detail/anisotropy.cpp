#include "points/detail/anisotropy.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "points/detail/neighbor_batches.hpp"
#include "points/detail/symmetric_eigen.hpp"

namespace isoextract::points {
namespace {

// Eigenvalue of (9) for constant density on all sides, in units of r^2.
constexpr double kFullVariance = 0.15;

struct ShapedKernel {
  glm::dvec3 center;
  float weight;
  Ellipsoid shape;
};

// Returns the kernel of a spot from the moments about target t, which are in units of `radius`.
ShapedKernel shape_of(const CellGrid& grid, std::size_t spot, const Moments& moments, std::size_t t, double radius,
                      double support, float density, const AnisotropyOptions& options) {
  const auto sum = [&](Moments::Sum m) { return static_cast<double>(moments.sums[m][t]); };
  const double total = sum(Moments::kTotal);
  const glm::dvec3 mean = glm::dvec3(sum(Moments::kX), sum(Moments::kY), sum(Moments::kZ)) / total;
  const double xy = sum(Moments::kXY);
  const double xz = sum(Moments::kXZ);
  const double yz = sum(Moments::kYZ);
  const glm::dmat3 second(sum(Moments::kXX), xy, xz, xy, sum(Moments::kYY), yz, xz, yz, sum(Moments::kZZ));
  const SymmetricEigen eigen = symmetric_eigen(second / total - glm::outerProduct(mean, mean));
  glm::dvec3 axes = options.k_s / kFullVariance * eigen.values;
  const auto members = static_cast<double>(grid.members(spot).size());
  if (sum(Moments::kPoints) - members <= options.few || axes.x < options.k_n) {
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
  kernel.center = grid.place(spot) + options.lambda * radius * mean;
  kernel.weight = static_cast<float>(members / (static_cast<double>(density) * axes.x * axes.y * axes.z));
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
  auto shaped = TRY(make_reserved_buffer<ShapedKernel>(grid.size(), context, what));
  auto centers = TRY(make_reserved_buffer<glm::dvec3>(grid.size(), context, what));
  context.progress().begin("shaping kernels", grid.size());
  const double radius = options.neighborhood * support;
  AnisotropicKernels kernels;
  kernels.reach = reduce_ranges(
      grid.cell_count(), 32, 0.0,
      [&](std::size_t begin, std::size_t end, double reach) {
        if (context.cancelled()) return reach;
        Moments moments;
        for (std::size_t c = begin; c != end; ++c) {
          for_each_neighbor_batch(
              grid, c, radius, [&](const CellTargets&) { moments = Moments(); },
              [&](const CellTargets& targets, const BallBatch& batch) {
                add_moments(batch, targets.x.data(), targets.y.data(), targets.z.data(), targets.padded, moments);
              },
              [&](const CellTargets& targets) {
                for (std::size_t t = 0; t < targets.size; ++t) {
                  const std::size_t s = targets.first + t;
                  const ShapedKernel kernel = shape_of(grid, s, moments, t, radius, support, densities[s], options);
                  shaped->values[s] = kernel;
                  centers->values[s] = kernel.center;
                  reach = std::max(reach, static_cast<double>(kernel.shape.reach));
                }
              });
        }
        context.progress().advance(grid.cell_end(end - 1) - grid.cell(begin).first);
        return reach;
      },
      [](double a, double b) { return std::max(a, b); });
  TRY(context.check());

  kernels.grid = TRY(CellGrid::make(std::as_const(centers->values).span(), GridFrame{}, grid.side(),
                                    CellGrid::Coinciding::apart, context, label));
  centers.reset();
  auto weights = TRY(make_reserved_buffer<float>(grid.size(), context, what));
  auto shapes = TRY(make_reserved_buffer<Ellipsoid>(grid.size(), context, what));
  auto counts = TRY(make_reserved_buffer<std::uint32_t>(grid.size(), context, what));
  for (std::size_t s = 0; s < grid.size(); ++s) {
    const std::size_t from = kernels.grid.members(s)[0];
    weights->values[s] = shaped->values[from].weight;
    shapes->values[s] = shaped->values[from].shape;
    counts->values[s] = static_cast<std::uint32_t>(grid.members(from).size());
  }
  kernels.weights = std::move(weights);
  kernels.shapes = std::move(shapes);
  kernels.counts = std::move(counts);
  return kernels;
}

}  // namespace isoextract::points
