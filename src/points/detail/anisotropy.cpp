#include "points/detail/anisotropy.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "points/detail/neighbor_batches.hpp"
#include "points/detail/symmetric_eigen.hpp"

namespace isoextract::points {
namespace {

// Eigenvalue of (9), in units of r^2, and mean of w, both for constant density on all sides.
constexpr double kFullVariance = 0.15;
constexpr double kMeanWeight = 0.5;
// Shortest half axis of a kernel, in samples.
constexpr double kMinHalfAxis = 3;
// Range of 1 - s_3 / s_1 in which kernels widen.
constexpr double kRound = 0.1;
constexpr double kFlat = 0.7;
// A layer: its radius and half its thickness, in supports.
constexpr double kLayerRadius = 1.4;
constexpr double kLayerDepth = 0.5;
// Distance of a particle from the mean of its neighbors, in supports, up to which it is deep inside.
constexpr double kDeepInside = 0.2;

struct ShapedKernel {
  glm::vec3 to_mean;  // from the particle to the mean of its neighbors, in grid coordinates
  float weight;
  Ellipsoid shape;
};

// Returns the lengths of the axes in supports. `variances` are the eigenvalues of (9) in units of r^2, descending.
glm::dvec3 axes_of(const glm::dvec3& variances, double neighbors, double support, const AnisotropyOptions& options) {
  const double flatness = 1 - variances.z / std::max(variances.x, std::numeric_limits<double>::min());
  const double wide = 1 + (options.widest - 1) * std::clamp((flatness - kRound) / (kFlat - kRound), 0.0, 1.0);
  const double shortest = std::max(options.shortest, kMinHalfAxis / support);
  const glm::dvec3 axes =
      glm::max(wide / std::max(variances.x, std::numeric_limits<double>::min()) * variances, glm::dvec3(shortest));
  const double narrow = std::min(neighbors / std::max(options.few, 1), variances.x / (options.k_n * kFullVariance));
  return glm::mix(glm::dvec3(options.k_n), axes, std::clamp(narrow - 1, 0.0, 1.0));
}

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
  const auto members = static_cast<double>(grid.members(spot).size());
  const glm::dvec3 axes = axes_of(eigen.values, (total - members) / kMeanWeight, support, options);
  const glm::dvec3 half = support * axes;
  glm::dmat3 form(0.0);
  for (int n = 0; n < 3; ++n) {
    form += glm::outerProduct(eigen.vectors[n], eigen.vectors[n]) / (half[n] * half[n]);
  }
  ShapedKernel kernel;
  kernel.to_mean = glm::vec3(radius * mean);
  kernel.weight = static_cast<float>(members / (static_cast<double>(density) * axes.x * axes.y * axes.z));
  kernel.shape = {static_cast<float>(form[0][0]), static_cast<float>(form[1][0]), static_cast<float>(form[2][0]),
                  static_cast<float>(form[1][1]), static_cast<float>(form[2][1]), static_cast<float>(form[2][2]),
                  static_cast<float>(half.x)};
  return kernel;
}

// Returns the step from a spot to the mean depth of its layer. `to_mean` points from the spot into the body.
glm::dvec3 step_to_layer(const CellGrid& grid, std::size_t spot, const glm::dvec3& to_mean, double support) {
  const double length = glm::length(to_mean);
  const double deep = kDeepInside * support;
  if (!(length > deep)) return glm::dvec3(0.0);
  const glm::dvec3 inward = to_mean / length;
  const glm::dvec3 at = grid.position(spot);
  const double radius = kLayerRadius * support;
  double sum = 0;
  double total = 0;
  grid.for_each_spot_run(at - radius, at + radius, [&](std::size_t first, std::size_t last) {
    for (std::size_t s = first; s != last; ++s) {
      const glm::dvec3 d = (grid.position(s) - at) / radius;
      const double depth = glm::dot(d, inward) * (kLayerRadius / kLayerDepth);
      const double near = 1 - glm::dot(d, d);
      const double level = 1 - depth * depth;
      if (near <= 0 || level <= 0) continue;
      const double w = near * near * level * level * static_cast<double>(grid.members(s).size());
      sum += w * depth;
      total += w;
    }
  });
  // Grows from 0 where "deep inside" ends, so that the result is continuous.
  const double share = std::min(1.0, length / deep - 1);
  return inward * (share * sum / total * kLayerDepth * support);
}

}  // namespace

double anisotropic_reach(const AnisotropyOptions& options, double support) {
  const double half_axis = std::max(options.widest * support, kMinHalfAxis);
  const double step = options.lambda * kLayerDepth * support;
  const double neighbors = std::max(options.neighborhood, kLayerRadius) * support;  // exceeds that of a density
  return half_axis + step + neighbors;
}

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
                  shaped->values[s] = shape_of(grid, s, moments, t, radius, support, densities[s], options);
                  reach = std::max(reach, static_cast<double>(shaped->values[s].shape.reach));
                }
              });
        }
        context.progress().advance(grid.cell_end(end - 1) - grid.cell(begin).first);
        return reach;
      },
      [](double a, double b) { return std::max(a, b); });
  TRY(context.check());
  context.progress().begin("moving kernels", grid.size());
  for_each_range(grid.size(), 512, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (std::size_t s = begin; s != end; ++s) {
      const glm::dvec3 to_mean(shaped->values[s].to_mean);
      centers->values[s] = grid.position(s) + options.lambda * step_to_layer(grid, s, to_mean, support);
    }
    context.progress().advance(end - begin);
  });
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
