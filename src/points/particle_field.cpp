#include "points/particle_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "base/checked.hpp"
#include "base/parallel.hpp"
#include "points/cell_grid.hpp"
#include "points/detail/anisotropy.hpp"
#include "points/detail/ball_kernels.hpp"
#include "points/detail/box_samples.hpp"
#include "points/detail/field_lengths.hpp"
#include "points/detail/kernel_bricks.hpp"
#include "points/detail/neighbor_batches.hpp"
#include "points/detail/particle_radii.hpp"
#include "points/detail/periodic_images.hpp"
#include "points/detail/sparse_bricks.hpp"
#include "points/detail/spot_density.hpp"
#include "points/detail/weight_bricks.hpp"
#include "points/particle_statistics.hpp"

namespace isoextract::points {
namespace {

constexpr double kBrickSide = field::SparseBlock::kSize;
constexpr double kInside = 1;  // value of tiles: about the value of the field within the liquid
// Limit of the average number of particles in the grid cells around a particle, so that run time is linear in the
// number of particles. The cells hold about 6 times as many particles as are within reach: 216 of touching particles
// with the usual kernel width, 1000 with anisotropic kernels.
constexpr std::uint64_t kMaxNeighbors = 32768;

Result<void> check_positive(double value, const char* what) {
  if (std::isfinite(value) && value > 0) return {};
  return fail(ErrorCode::usage, fmt::format("expected {} above 0, found {}", what, value));
}

// Returns the mapping from world to index coordinates, (p - origin) / unit; its origin is a multiple of the brick size.
Result<GridFrame> index_frame(const ParticleSet& particles, const ParticleBounds& bounds, double spacing,
                              double reach) {
  const glm::dvec3 center = bounds.box.min / 2.0 + bounds.box.max / 2.0;
  const glm::dvec3 half = bounds.box.max / 2.0 - bounds.box.min / 2.0;
  const double half_size = std::max({half.x, half.y, half.z});
  const glm::dvec3 far = glm::max(glm::abs(bounds.box.min), glm::abs(bounds.box.max));
  const double farthest = std::max({far.x, far.y, far.z});
  // Two bricks of margin for rounding to bricks and for the reach of kernels.
  if (!(half_size / spacing + reach + 2 * kBrickSide < field::kMaxSparseIndex)) {
    return fail(ErrorCode::input,
                fmt::format("{}: the particles extend over {:.6g} units, more than {} samples at a spacing of {:.6g}",
                            particles.label, 2 * half_size, 2LL * field::kMaxSparseIndex, spacing),
                {{Remedy::set, Setting::selection, "CONDITION to leave stray particles out"},
                 {Remedy::raise, Setting::cell_size}});
  }
  // Sample positions are rounded to double; the error must stay below a hundredth of the spacing.
  if (!(farthest * std::numeric_limits<double>::epsilon() < spacing / 100)) {
    return fail(ErrorCode::input,
                fmt::format("{}: coordinates reach {}, where double precision is too coarse for a spacing of {}",
                            particles.label, farthest, spacing),
                Hint("move the particles nearer to 0"));
  }
  return GridFrame{glm::round(center / (kBrickSide * spacing)) * (kBrickSide * spacing), spacing};
}

// Returns the number of spots of the cell with the most.
std::uint64_t largest_cell(const CellGrid& grid) {
  std::uint64_t most = 0;
  for (std::size_t c = 0; c < grid.cell_count(); ++c) {
    most = std::max<std::uint64_t>(most, grid.cell_end(c) - grid.cell(c).first);
  }
  return most;
}

// Fails if the radius is so large relative to the particle distances that nearly all kernels overlap. Counts all
// particles in the cells that a search visits, as these determine the run time. `support` is that of the largest
// kernel, in samples.
Result<void> check_crowding(const ParticleSet& particles, const CellGrid& grid, const FieldOptions& options,
                            double support, const ParticleFieldStatistics& figures, const Context& context) {
  const bool is_anisotropic = options.method == Method::anisotropic;
  const double widening = is_anisotropic ? std::max(1.0, options.anisotropy.neighborhood) : 1;
  const std::uint64_t most = kMaxNeighbors * grid.size();
  const auto side = static_cast<std::uint64_t>(2 * std::ceil(widening * support / grid.side()) + 1);
  const auto bound = checked_product(largest_cell(grid), side * side * side);
  if (bound && *bound <= kMaxNeighbors) return {};
  if (count_candidate_pairs(grid, widening * support, most) <= most) return {};
  const std::optional<double> usual = TRY(suggest_radius(particles, context));
  return fail(ErrorCode::input,
              fmt::format("{}: neighborhoods with a reach of {:.6g} hold too many of the {} particles: expected at "
                          "most {} on average in a cube of edge {:.6g} around a particle, found more",
                          particles.label, widening * support * figures.spacing, figures.particles, kMaxNeighbors,
                          static_cast<double>(side) * grid.side() * figures.spacing),
              Hint(Remedy::give, Setting::radius,
                   usual ? fmt::format("{:.6g} fits the density of the particles", *usual) : ""));
}

// The particles that make the field.
struct UsedParticles {
  std::span<const glm::dvec3> positions;  // not finite for particles left out
  std::span<const float> radii;           // one per particle if they have unlike radii that the method uses, else empty
  double median_radius = 0;               // of `radii`
  double support = 0;                     // of a kernel in samples; with `radii` that of the median radius
  double reach = 0;                       // of the largest kernel, in samples

  [[nodiscard]] CellGrid::Coinciding coinciding() const {
    return radii.empty() ? CellGrid::Coinciding::merged : CellGrid::Coinciding::apart;
  }
};

// The samples of a periodic box, and how many of the points are particles and no images.
struct PeriodicParticles {
  BoxSamples box;
  std::size_t originals;  // points with a lower index are particles, others their images
};

// With `periodic`, `grid` and `used` have images, and `grid` is in Cartesian coordinates of the box (BoxSamples).
Result<field::SparseSamples> sum_kernels(const CellGrid& grid, const UsedParticles& used, const FieldOptions& options,
                                         const PeriodicParticles* periodic, BrickCounts& counts, const Context& context,
                                         const std::string& label) {
  std::optional<double> iso = options.tile_iso;
  if (iso && *iso >= kInside) iso.reset();
  const auto first_point = [&](std::size_t spot) { return grid.members(spot)[0]; };
  const auto fill = [&](const KernelSet& kernels, const auto& point_of) -> Result<field::SparseSamples> {
    if (periodic == nullptr) {
      return fill_bricks(KernelBricks(kernels), iso, kInside, std::nullopt, counts, context, label);
    }
    const auto repeated = TRY(repeat_kernels(
        kernels, [&](std::size_t kernel) { return point_of(kernel) < periodic->originals; }, periodic->box,
        options.margin, context, label));
    return fill_bricks(KernelBricks(repeated.set()), iso, kInside, needed_samples(periodic->box, options.margin),
                       counts, context, label);
  };
  if (!used.radii.empty()) {
    const auto kernels =
        TRY(BallKernels::make(grid, used.radii, used.support / used.median_radius, used.reach, context, label));
    return fill(kernels.set(), first_point);
  }
  auto densities = TRY(compute_spot_densities(grid, used.support, context, label));
  float* const values = densities->values.data();
  if (options.method == Method::anisotropic) {
    auto kernels = TRY(make_anisotropic_kernels(grid, used.support, values, options.anisotropy, context, label));
    densities.reset();
    return fill(kernels.set(), [&](std::size_t kernel) { return first_point(kernels.grid.members(kernel)[0]); });
  }
  // m / rho_j W(0): the spot's members divided by its density relative to an isolated particle.
  for_each_range(grid.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s != end; ++s) {
      values[s] = static_cast<float>(grid.members(s).size()) / values[s];
    }
  });
  return fill({&grid, values, nullptr, nullptr, used.support}, first_point);
}

// Makes the samples of particles without a periodic box, and sets their placement in `result`.
Result<field::SparseSamples> fill_open_space(const ParticleSet& particles, const UsedParticles& used,
                                             const ParticleBounds& bounds, const FieldOptions& options,
                                             const std::function<void()>& free_positions, BrickCounts& counts,
                                             const Context& context, ParticleField& result) {
  const ParticleFieldStatistics& figures = result.figures;
  const bool weighs = options.method == Method::weight;
  auto frame = TRY(index_frame(particles, bounds, figures.spacing, weighs ? 1 : used.reach));
  auto grid = TRY(CellGrid::make(used.positions, frame, weighs ? 1 : std::max(used.support, 2.0), used.coinciding(),
                                 context, particles.label));
  result.field.index_to_world = {glm::dmat3(figures.spacing), frame.origin};
  if (weighs) {
    free_positions();
    return fill_bricks(WeightBricks(grid, options.deposit, options.weight), std::nullopt, kInside, std::nullopt, counts,
                       context, particles.label);
  }
  TRY(check_crowding(particles, grid, options, used.reach, figures, context));
  free_positions();
  return sum_kernels(grid, used, options, nullptr, counts, context, particles.label);
}

// Makes the samples of particles in a periodic box, and sets their placement and the region in `result`.
Result<field::SparseSamples> fill_periodic_box(const ParticleSet& particles, const UsedParticles& used,
                                               const FieldOptions& options, BrickCounts& counts, const Context& context,
                                               ParticleField& result) {
  const ParticleFieldStatistics& figures = result.figures;
  const PeriodicParticles periodic{TRY(BoxSamples::make(*particles.box, figures.spacing, particles.label)),
                                   used.positions.size()};
  const BoxSamples& box = periodic.box;
  result.region = box.region();
  result.field.index_to_world = box.world_from_index();
  if (options.method == Method::weight) {
    const auto all = TRY(with_images(used.positions, box, reach_of_images(glm::dvec3(1), options.margin),
                                     Coordinates::index, context, particles.label));
    const auto grid = TRY(CellGrid::make(all.positions(), GridFrame{}, 2, used.coinciding(), context, particles.label));
    return fill_bricks(WeightBricks(grid, options.deposit, options.weight), std::nullopt, kInside,
                       needed_samples(box, options.margin), counts, context, particles.label);
  }
  // Two supports more than the neighborhood reaches, so that the kernels of neighbors are right, too.
  const double neighbors =
      options.method == Method::anisotropic ? std::max(1.0, options.anisotropy.neighborhood) + 2 : 1;
  const auto all = TRY(with_images(used.positions, box, box.extent_of_ball(neighbors * used.reach),
                                   Coordinates::cartesian, context, particles.label));
  const auto grid = TRY(CellGrid::make(all.positions(), GridFrame{}, std::max(used.support, 2.0), used.coinciding(),
                                       context, particles.label));
  TRY(check_crowding(particles, grid, options, used.reach, figures, context));
  const auto radii = TRY(make_reserved_buffer<float>(used.radii.empty() ? 0 : all.positions().size(), context,
                                                     particles.label + ": radii of particles"));
  for (std::size_t i = 0; i < radii->values.size(); ++i) radii->values[i] = used.radii[all.sources->values[i]];
  UsedParticles repeated = used;
  repeated.radii = std::as_const(radii->values).span();
  return sum_kernels(grid, repeated, options, &periodic, counts, context, particles.label);
}

}  // namespace

Result<void> check_options(const FieldOptions& options) {
  if (options.cell_size && options.spacing) {
    return fail(ErrorCode::usage,
                "expected the spacing of the samples in particle radii or in world units, found both");
  }
  const AnisotropyOptions& anisotropy = options.anisotropy;
  for (const auto& [value, what] :
       {std::pair(options.radius.value_or(1), "a particle radius"),
        std::pair(options.suggested_radius.value_or(1), "a suggested particle radius"),
        std::pair(options.median_radius.value_or(1), "a median particle radius"),
        std::pair(options.cell_size.value_or(1), "a cell size in radii"),
        std::pair(options.spacing.value_or(1), "a spacing of the samples"),
        std::pair(options.smoothing_length, "a smoothing length in radii"), std::pair(options.weight, "a weight"),
        std::pair(anisotropy.neighborhood, "a neighborhood radius in kernel supports")}) {
    TRY(check_positive(value, what));
  }
  for (const auto& [value, what] :
       {std::pair(anisotropy.shortest, "the shortest axis of kernels (in supports)"),
        std::pair(anisotropy.k_n, "k_n, the radius of kernels with few neighbors (in supports)")}) {
    TRY(check_positive(value, what));
    if (value > 1) return fail(ErrorCode::usage, fmt::format("expected at most 1 for {}, found {}", what, value));
  }
  if (!(anisotropy.lambda >= 0 && anisotropy.lambda <= 1)) {
    return fail(ErrorCode::usage, fmt::format("expected a lambda from 0 to 1 (how far kernel centers move), found {}",
                                              anisotropy.lambda));
  }
  if (!(std::isfinite(anisotropy.widest) && anisotropy.widest >= 1)) {
    return fail(ErrorCode::usage,
                fmt::format("expected axes along a surface of at least 1 kernel support, found {}", anisotropy.widest));
  }
  if (anisotropy.few < 0) {
    return fail(
        ErrorCode::usage,
        fmt::format("expected N_eps of at least 0 (a kernel with at most N_eps neighbors is a sphere), found {}",
                    anisotropy.few));
  }
  if (options.margin < 0) {
    return fail(ErrorCode::usage, fmt::format("expected a margin of at least 0 samples, found {}", options.margin));
  }
  if (options.tile_iso && !std::isfinite(*options.tile_iso)) {
    return fail(ErrorCode::usage, fmt::format("expected a finite iso value, found {}", *options.tile_iso));
  }
  return {};
}

namespace {

// `free_positions` is called when only the positions in the grid are needed.
Result<ParticleField> make_field(const ParticleSet& particles, const FieldOptions& options,
                                 const std::function<void()>& free_positions, const Context& context) {
  TRY(check_options(options));
  const std::span<const glm::dvec3> positions = particles.positions.span();
  if (method_info(options.method).kind != field::FieldKind::density) {
    return fail(ErrorCode::usage, fmt::format("{}: expected a method that sums particle contributions, found {}",
                                              particles.label, method_info(options.method).title));
  }
  const ParticleBounds bounds = measure_bounds(positions);
  TRY(check_positions(particles, bounds, options.non_finite));
  ParticleField result;
  ParticleFieldStatistics& figures = result.figures;
  figures.particles = bounds.finite;
  figures.particles_dropped = bounds.not_finite;
  result.field.name = particles.label;
  result.field.source = particles.label;
  result.field.format = "particles";
  if (bounds.finite == 0) {
    result.field.samples = field::SparseSamples{};
    return result;
  }
  const auto radii = TRY(find_radii(particles, options, bounds, context));
  if (radii) {
    figures.radius = radii->median;
    figures.radius_attribute = radii->attribute->name;
  }
  TRY(resolve_lengths(particles, options, figures, context));
  UsedParticles used;
  used.positions = positions;
  used.support = figures.support / figures.spacing;
  used.reach = used.support;
  LargeEnough large;
  if (radii && radii->min < radii->max && options.method == Method::sph) {
    used.radii = radii->attribute->values.span();
    used.median_radius = radii->median;
    used.reach *= radii->max / radii->median;
    const double smallest = radii->median / used.support;  // its kernel reaches one sample far
    if (radii->min < smallest) {
      large = TRY(leave_out_small(positions, used.radii, smallest, context, particles.label));
      used.positions = std::as_const(large.positions->values).span();
      figures.particles_too_small = large.too_small;
      figures.least_radius = smallest / figures.spacing;
      figures.particles -= large.too_small;
    }
  }
  BrickCounts counts;
  const bool is_periodic = particles.box && particles.box->is_periodic();
  result.field.samples =
      TRY(is_periodic ? fill_periodic_box(particles, used, options, counts, context, result)
                      : fill_open_space(particles, used, bounds, options, free_positions, counts, context, result));
  figures.bricks_stored = counts.bricks_stored;
  figures.inside_tiles = counts.inside_tiles;
  figures.particles_deep_inside = counts.particles_deep_inside;
  return result;
}

}  // namespace

Result<ParticleField> make_field(const ParticleSet& particles, const FieldOptions& options, const Context& context) {
  return make_field(
      particles, options, [] {}, context);
}

Result<ParticleField> make_field_and_free(ParticleSet& particles, const FieldOptions& options, const Context& context) {
  const auto free_positions = [&] {
    particles.memory.shrink(particles.memory.bytes() -
                            std::min<std::uint64_t>(particles.memory.bytes(), particles.positions.size_bytes()));
    particles.positions = {};
  };
  return make_field(particles, options, free_positions, context);
}

}  // namespace isoextract::points
