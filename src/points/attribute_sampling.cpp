#include "points/attribute_sampling.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "field/samples.hpp"
#include "points/cell_grid.hpp"
#include "points/detail/cubic_spline.hpp"
#include "points/detail/nearest_tree.hpp"
#include "points/detail/source_points.hpp"
#include "points/detail/spot_density.hpp"
#include "points/particle_statistics.hpp"

namespace isoextract::points {
namespace {

// Returns the attribute of each spot: the mean over its particles.
Result<std::shared_ptr<ReservedBuffer<float>>> average_by_spot(const CellGrid& grid, const SourcePoints& points,
                                                               const ParticleAttribute& attribute,
                                                               const Context& context, const std::string& what) {
  auto made = make_reserved_buffer<float>(grid.size() * attribute.components, context, what);
  if (!made) return made;
  for_each_range(grid.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s != end; ++s) {
      for (std::size_t c = 0; c < attribute.components; ++c) {
        double sum = 0;
        for (const std::uint32_t point : grid.members(s)) {
          sum += static_cast<double>(attribute.values[points.particle(point) * attribute.components + c]);
        }
        (*made)->values[s * attribute.components + c] =
            static_cast<float>(sum / static_cast<double>(grid.members(s).size()));
      }
    }
  });
  return made;
}

// Calls f(spot, m / rho_j W / W(0)) for the kernels that reach `p`. Positions are in grid coordinates with support 1.
template <class F>
void for_each_kernel_at(const CellGrid& grid, const float* densities, const glm::dvec3& p, const F& f) {
  grid.for_each_spot_run(p - 1.0, p + 1.0, [&](std::size_t first, std::size_t last) {
    for (std::size_t s = first; s != last; ++s) {
      const glm::dvec3 away = grid.position(s) - p;
      const double squared = glm::dot(away, away);
      if (squared >= 1) continue;
      const double shape = spline_shape(std::sqrt(squared));
      // Near the rim the value can round to 0.
      if (shape > 0) f(s, shape * static_cast<double>(grid.members(s).size()) / static_cast<double>(densities[s]));
    }
  });
}

}  // namespace

Result<SampledAttributes> sample_attributes(const ParticleSet& particles, std::span<const std::size_t> attributes,
                                            std::span<const glm::dvec3> vertices, double radius,
                                            double smoothing_length, const Context& context) {
  const double support = 2 * smoothing_length * radius;
  if (!(radius > 0 && smoothing_length > 0 && std::isfinite(support))) {
    return fail(ErrorCode::usage,
                fmt::format("expected a particle radius and a smoothing length above 0, found {} and {}", radius,
                            smoothing_length));
  }
  const auto points = TRY(SourcePoints::make(particles, support, context));
  const std::span<const glm::dvec3> positions = points.positions();
  const ParticleBounds bounds = measure_bounds(positions);
  if (bounds.finite == 0 && !vertices.empty()) {
    return fail(ErrorCode::input, particles.label + ": expected particles with attributes, found none");
  }
  std::size_t components = 0;
  for (const std::size_t a : attributes) components += particles.attributes[a].components;
  const std::string what =
      fmt::format("{}: {} attributes of {} vertices", particles.label, attributes.size(), vertices.size());
  auto memory = TRY(context.reserve(components * vertices.size() * sizeof(float), what));
  SampledAttributes result;
  result.memory = std::move(memory);
  for (const std::size_t a : attributes) {
    const ParticleAttribute& from = particles.attributes[a];
    result.attributes.push_back({from.name, from.components, Buffer<float>(from.components * vertices.size())});
  }
  if (vertices.empty()) return result;

  const GridFrame frame{bounds.box.min / 2.0 + bounds.box.max / 2.0, points.support()};
  const glm::dvec3 half = frame(bounds.box.max);
  if (!(std::max({half.x, half.y, half.z}) < field::kMaxSparseIndex)) {
    return fail(ErrorCode::input, fmt::format("{}: the particles are too far apart for kernels with a reach of {}",
                                              particles.label, support));
  }
  auto grid = TRY(CellGrid::make(positions, frame, 1, CellGrid::Coinciding::merged, context, particles.label));
  auto densities = TRY(compute_spot_densities(grid, 1, context, particles.label));
  std::vector<std::shared_ptr<ReservedBuffer<float>>> means;
  for (const std::size_t a : attributes) {
    auto made = TRY(average_by_spot(grid, points, particles.attributes[a], context, what));
    means.push_back(std::move(made));
  }
  auto flags = TRY(make_reserved_buffer<std::uint8_t>(vertices.size(), context, what));

  context.progress().begin("sampling attributes", vertices.size());
  std::atomic<std::uint64_t> vertices_beyond_kernels{0};
  for_each_range(vertices.size(), 512, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    std::vector<double> sums(components);
    for (std::size_t v = begin; v != end; ++v) {
      // Vertices beyond the reach of every kernel are excluded first: their cell coordinates could overflow an int.
      const glm::dvec3 p = frame(points.place_of(vertices[v]));
      const bool near = glm::all(glm::lessThan(glm::abs(p), half + 1.5));
      double total = 0;
      std::ranges::fill(sums, 0.0);
      if (near) {
        for_each_kernel_at(grid, densities->values.data(), p, [&](std::size_t spot, double share) {
          total += share;
          double* sum = sums.data();
          for (std::size_t a = 0; a < means.size(); ++a) {
            const std::size_t width = result.attributes[a].components;
            for (std::size_t c = 0; c < width; ++c) {
              *sum++ += share * static_cast<double>(means[a]->values[spot * width + c]);
            }
          }
        });
      }
      flags->values[v] = static_cast<std::uint8_t>(total == 0);
      if (total == 0) vertices_beyond_kernels.fetch_add(1, std::memory_order_relaxed);
      const double* sum = sums.data();
      for (SampledAttribute& attribute : result.attributes) {
        for (std::size_t c = 0; c < attribute.components; ++c) {
          attribute.values[v * attribute.components + c] = static_cast<float>(*sum++ / total);
        }
      }
    }
    context.progress().advance(end - begin);
  });
  TRY(context.check());
  result.vertices_beyond_kernels = vertices_beyond_kernels.load();
  if (result.vertices_beyond_kernels == 0) return result;

  auto tree = TRY(NearestTree::make(positions, context, particles.label));
  for_each_range(vertices.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v != end; ++v) {
      if (flags->values[v] == 0) continue;
      const std::size_t nearest = points.particle(tree.nearest(points.place_of(vertices[v])).point);
      for (std::size_t a = 0; a < attributes.size(); ++a) {
        const std::size_t width = result.attributes[a].components;
        std::copy_n(particles.attributes[attributes[a]].values.data() + nearest * width, width,
                    result.attributes[a].values.data() + v * width);
      }
    }
  });
  return result;
}

}  // namespace isoextract::points
