#include "points/particle_field.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "points/cell_grid.hpp"
#include "points/detail/anisotropy.hpp"
#include "points/detail/ball_kernels.hpp"
#include "points/detail/field_lengths.hpp"
#include "points/detail/kernel_bricks.hpp"
#include "points/detail/neighbor_batches.hpp"
#include "points/detail/particle_radii.hpp"
#include "points/detail/sparse_bricks.hpp"
#include "points/detail/spot_density.hpp"
#include "points/detail/weight_bricks.hpp"
#include "points/particle_statistics.hpp"

namespace isoextract::points {
namespace {

constexpr double kBrickSide = field::SparseBlock::kSize;
constexpr double kInside = 1;  // value of tiles: about the value of the field within the liquid
// Limit of the average number of particles within a kernel's reach, so that run time is linear in their number.
// Touching particles with the usual kernel width have 216, with anisotropic kernels 1000.
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
                fmt::format("{}: the particles extend over {} units, more than {} samples at a spacing of {}",
                            particles.label, 2 * half_size, 2LL * field::kMaxSparseIndex, spacing),
                Hint("use a larger radius or spacing, or remove stray particles"));
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

// Fails if the radius is so large relative to the particle distances that nearly all kernels overlap. `support` is that
// of the largest kernel, in samples.
Result<void> check_crowding(const ParticleSet& particles, const CellGrid& grid, const FieldOptions& options,
                            double support, const ParticleFieldStatistics& figures, const Context& context) {
  const bool is_anisotropic = options.method == Method::anisotropic;
  const double widening = is_anisotropic ? std::max(1.0, options.anisotropy.neighborhood) : 1;
  const std::uint64_t most = kMaxNeighbors * grid.size();
  if (count_neighbor_pairs(grid, widening * support, most) <= most) return {};
  const std::optional<double> usual = TRY(suggest_radius(particles, context));
  return fail(
      ErrorCode::input,
      fmt::format(
          "{}: expected at most {} neighbors per particle on average, found more ({} particles with a radius of "
          "{:.6g}, neighbors up to {:.6g} away)",
          particles.label, kMaxNeighbors, figures.particles, figures.radius, widening * support * figures.spacing),
      Hint(Remedy::give, Setting::radius,
           usual ? fmt::format("{:.6g} fits the density of the particles", *usual) : ""));
}

Result<field::SparseSamples> sum_kernels(const CellGrid& grid, double support, const FieldOptions& options,
                                         BrickCounts& counts, const Context& context, const std::string& label) {
  auto densities = TRY(compute_spot_densities(grid, support, context, label));
  float* const values = densities->values.data();
  std::optional<double> iso = options.tile_iso;
  if (iso && *iso >= kInside) iso.reset();
  if (options.method == Method::anisotropic) {
    auto kernels = TRY(make_anisotropic_kernels(grid, support, values, options.anisotropy, context, label));
    densities.reset();
    return fill_bricks(KernelBricks(kernels.set()), iso, kInside, counts, context, label);
  }
  // m / rho_j W(0): the spot's members divided by its density relative to an isolated particle.
  for_each_range(grid.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s != end; ++s) {
      values[s] = static_cast<float>(grid.members(s).size()) / values[s];
    }
  });
  return fill_bricks(KernelBricks({&grid, values, nullptr, nullptr, support}), iso, kInside, counts, context, label);
}

// Does the same for particles with unlike radii. `support` is that of the median radius.
Result<field::SparseSamples> sum_balls(const CellGrid& grid, const ParticleRadii& radii, double support,
                                       const FieldOptions& options, BrickCounts& counts, const Context& context,
                                       const std::string& label) {
  const double of_unit = support / radii.median;
  const auto kernels =
      TRY(BallKernels::make(grid, radii.attribute->values.span(), of_unit, of_unit * radii.max, context, label));
  std::optional<double> iso = options.tile_iso;
  if (iso && *iso >= kInside) iso.reset();
  return fill_bricks(KernelBricks(kernels.set()), iso, kInside, counts, context, label);
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
        std::pair(options.cell_size.value_or(1), "a cell size in radii"),
        std::pair(options.spacing.value_or(1), "a spacing of the samples"),
        std::pair(options.smoothing_length, "a smoothing length in radii"), std::pair(options.weight, "a weight"),
        std::pair(anisotropy.neighborhood, "a neighborhood radius in kernel supports"),
        std::pair(anisotropy.shortest, "a shortest axis of kernels in supports"),
        std::pair(anisotropy.k_n, "a radius k_n of kernels with few neighbors in supports")}) {
    TRY(check_positive(value, what));
  }
  for (const auto& [value, what] :
       {std::pair(anisotropy.shortest, "a shortest axis of kernels in supports"),
        std::pair(anisotropy.k_n, "a radius k_n of kernels with few neighbors in supports")}) {
    if (value > 1) return fail(ErrorCode::usage, fmt::format("expected {} of at most 1, found {}", what, value));
  }
  if (!(anisotropy.lambda >= 0 && anisotropy.lambda <= 1)) {
    return fail(ErrorCode::usage,
                fmt::format("expected lambda, how far kernel centers move, from 0 to 1, found {}", anisotropy.lambda));
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
  if (options.tile_iso && !std::isfinite(*options.tile_iso)) {
    return fail(ErrorCode::usage, fmt::format("expected a finite iso value, found {}", *options.tile_iso));
  }
  return {};
}

Result<ParticleField> make_field(const ParticleSet& particles, const FieldOptions& options, const Context& context) {
  TRY(check_options(options));
  const std::span<const glm::dvec3> positions = particles.positions.span();
  if (method_info(options.method).kind != field::FieldKind::density) {
    return fail(ErrorCode::usage, fmt::format("{}: expected a method that sums particle contributions, found {}",
                                              particles.label, method_info(options.method).title));
  }
  const ParticleBounds bounds = measure_bounds(positions);
  TRY(check_positions(particles, bounds, options.bad));
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
  const double support = figures.support / figures.spacing;
  const bool weighs = options.method == Method::weight;
  const bool is_mixed = radii && radii->min < radii->max && options.method == Method::sph;
  const double reach = is_mixed ? support * (radii->max / radii->median) : support;
  const double smallest = radii ? radii->median / support : 0;  // its kernel reaches one sample far
  LargeEnough large;
  if (is_mixed && radii->min < smallest) {
    large = TRY(leave_out_small(positions, radii->attribute->values.span(), smallest, context, particles.label));
    figures.particles_too_small = large.too_small;
    figures.least_radius = smallest / figures.spacing;
    figures.particles -= large.too_small;
  }
  auto frame = TRY(index_frame(particles, bounds, figures.spacing, weighs ? 1 : reach));
  auto grid = TRY(CellGrid::make(
      large.positions ? large.positions->values.span() : positions, frame, weighs ? 1 : std::max(support, 2.0),
      is_mixed ? CellGrid::Coinciding::apart : CellGrid::Coinciding::merged, context, particles.label));
  if (!weighs) {
    TRY(check_crowding(particles, grid, options, reach, figures, context));
  }
  BrickCounts counts;
  auto samples = TRY(weighs ? fill_bricks(WeightBricks(grid, options.deposit, options.weight), std::nullopt, kInside,
                                          counts, context, particles.label)
                     : is_mixed ? sum_balls(grid, *radii, support, options, counts, context, particles.label)
                                : sum_kernels(grid, support, options, counts, context, particles.label));
  figures.bricks_stored = counts.bricks_stored;
  figures.inside_tiles = counts.inside_tiles;
  figures.particles_deep_inside = counts.particles_deep_inside;
  result.field.index_to_world = {glm::dmat3(figures.spacing), frame.origin};
  result.field.samples = std::move(samples);
  return result;
}

}  // namespace isoextract::points
