#include "points/attribute_sampling.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/task_arena.h>

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

Result<void> check_lengths(double radius, double smoothing_length) {
  if (radius > 0 && smoothing_length > 0 && std::isfinite(2 * smoothing_length * radius)) return {};
  return fail(ErrorCode::usage,
              fmt::format("expected a particle radius and a smoothing length above 0, found {} and {}", radius,
                          smoothing_length));
}

// Returns room for the values of vertices.
Result<SampledAttributes> make_room(const ParticleSet& particles, std::span<const std::size_t> attributes,
                                    std::size_t vertices, const Context& context) {
  std::size_t components = 0;
  for (const std::size_t a : attributes) components += particles.attributes[a].components;
  SampledAttributes room;
  room.memory = TRY(
      context.reserve(components * vertices * sizeof(float),
                      fmt::format("{}: {} attributes of {} vertices", particles.label, attributes.size(), vertices)));
  for (const std::size_t a : attributes) {
    const ParticleAttribute& from = particles.attributes[a];
    room.attributes.push_back({from.name, from.components, Buffer<float>(from.components * vertices)});
  }
  return room;
}

}  // namespace

struct AttributeSampler::State {
  State(const ParticleSet& from, std::span<const std::size_t> which, SourcePoints&& at, const Context& of)
      : context(of), particles(from), attributes(which.begin(), which.end()), points(std::move(at)) {}

  Context context;  // of make()
  const ParticleSet& particles;
  std::vector<std::size_t> attributes;
  SourcePoints points;
  GridFrame frame;
  glm::dvec3 half{0.0};  // half of the box around the points, in grid coordinates
  std::optional<CellGrid> grid;
  std::shared_ptr<ReservedBuffer<float>> densities;
  std::vector<std::shared_ptr<ReservedBuffer<float>>> means;  // of each attribute, by spot
  std::mutex mutex;                                           // guards `tree` while it is made
  std::optional<NearestTree> tree;

  // Returns the tree of the particles; makes it on the first call.
  [[nodiscard]] Result<const NearestTree*> nearest() {
    const std::lock_guard lock(mutex);
    if (tree) return &*tree;
    Result<void> made;
    // A thread that holds the mutex must not begin other work that waits for it.
    tbb::this_task_arena::isolate([&] {
      auto result = NearestTree::make(points.positions(), context, particles.label);
      if (result) {
        tree.emplace(std::move(*result));
      } else {
        made = tl::unexpected(std::move(result.error()));
      }
    });
    TRY(std::move(made));
    return &*tree;
  }
};

AttributeSampler::AttributeSampler(std::unique_ptr<State> state) : state_(std::move(state)) {}
AttributeSampler::AttributeSampler(AttributeSampler&&) noexcept = default;
AttributeSampler& AttributeSampler::operator=(AttributeSampler&&) noexcept = default;
AttributeSampler::~AttributeSampler() = default;

Result<AttributeSampler> AttributeSampler::make(const ParticleSet& particles, std::span<const std::size_t> attributes,
                                                double radius, double smoothing_length, const Context& context) {
  TRY(check_lengths(radius, smoothing_length));
  const double support = 2 * smoothing_length * radius;
  auto points = TRY(SourcePoints::make(particles, support, context));
  auto state = std::make_unique<State>(particles, attributes, std::move(points), context);
  const std::span<const glm::dvec3> positions = state->points.positions();
  const ParticleBounds bounds = measure_bounds(positions);
  if (bounds.finite == 0) {
    return fail(ErrorCode::input, particles.label + ": expected particles with attributes, found none");
  }
  state->frame = {bounds.box.min / 2.0 + bounds.box.max / 2.0, state->points.support()};
  state->half = state->frame(bounds.box.max);
  if (!(std::max({state->half.x, state->half.y, state->half.z}) < field::kMaxSparseIndex)) {
    return fail(ErrorCode::input, fmt::format("{}: the particles are too far apart for kernels with a reach of {}",
                                              particles.label, support));
  }
  state->grid = TRY(CellGrid::make(positions, state->frame, 1, CellGrid::Coinciding::merged, context, particles.label));
  state->densities = TRY(compute_spot_densities(*state->grid, 1, context, particles.label));
  const std::string what = fmt::format("{}: {} attributes", particles.label, attributes.size());
  for (const std::size_t a : attributes) {
    state->means.push_back(TRY(average_by_spot(*state->grid, state->points, particles.attributes[a], context, what)));
  }
  return AttributeSampler(std::move(state));
}

Result<SampledAttributes> AttributeSampler::sample(std::span<const glm::dvec3> vertices, const Context& context) const {
  State& state = *state_;
  auto result = TRY(make_room(state.particles, state.attributes, vertices.size(), context));
  std::size_t components = 0;
  for (const SampledAttribute& attribute : result.attributes) components += attribute.components;
  auto flags = TRY(
      make_reserved_buffer<std::uint8_t>(vertices.size(), context, state.particles.label + ": attributes of vertices"));

  context.progress().begin("sampling attributes", vertices.size());
  std::atomic<std::uint64_t> vertices_beyond_kernels{0};
  for_each_range(vertices.size(), 512, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    std::vector<double> sums(components);
    for (std::size_t v = begin; v != end; ++v) {
      // Vertices beyond the reach of every kernel are excluded first: their cell coordinates could overflow an int.
      const glm::dvec3 p = state.frame(state.points.place_of(vertices[v]));
      const bool near = glm::all(glm::lessThan(glm::abs(p), state.half + 1.5));
      double total = 0;
      std::ranges::fill(sums, 0.0);
      if (near) {
        for_each_kernel_at(*state.grid, state.densities->values.data(), p, [&](std::size_t spot, double share) {
          total += share;
          double* sum = sums.data();
          for (std::size_t a = 0; a < state.means.size(); ++a) {
            const std::size_t width = result.attributes[a].components;
            for (std::size_t c = 0; c < width; ++c) {
              *sum++ += share * static_cast<double>(state.means[a]->values[spot * width + c]);
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

  const NearestTree& tree = *TRY(state.nearest());
  for_each_range(vertices.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v != end; ++v) {
      if (flags->values[v] == 0) continue;
      const std::size_t nearest = state.points.particle(tree.nearest(state.points.place_of(vertices[v])).point);
      for (std::size_t a = 0; a < state.attributes.size(); ++a) {
        const ParticleAttribute& from = state.particles.attributes[state.attributes[a]];
        const std::size_t width = result.attributes[a].components;
        std::copy_n(from.values.data() + nearest * width, width, result.attributes[a].values.data() + v * width);
      }
    }
  });
  return result;
}

Result<SampledAttributes> sample_attributes(const ParticleSet& particles, std::span<const std::size_t> attributes,
                                            std::span<const glm::dvec3> vertices, double radius,
                                            double smoothing_length, const Context& context) {
  TRY(check_lengths(radius, smoothing_length));
  if (vertices.empty()) return make_room(particles, attributes, 0, context);
  const auto sampler = TRY(AttributeSampler::make(particles, attributes, radius, smoothing_length, context));
  return sampler.sample(vertices, context);
}

}  // namespace isoextract::points
