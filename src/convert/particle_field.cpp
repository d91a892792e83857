#include "convert/particle_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "base/counted.hpp"
#include "base/printable.hpp"
#include "points/sphere_set.hpp"
#include "volume_io/grid_tools.hpp"

namespace isoextract::convert {
namespace {

// Returns options that refer to `spheres`, which must outlive them.
volume_io::SphereOptions sphere_options(const points::SphereSet& spheres, points::Method method) {
  const points::ParticleFieldStatistics& figures = spheres.figures();
  volume_io::SphereOptions options;
  options.method =
      method == points::Method::smooth ? volume_io::SphereMethod::smooth : volume_io::SphereMethod::spheres;
  options.radius = figures.radius;
  options.radii = spheres.radii();
  options.images = spheres.images();
  options.search_radius = figures.support;
  options.voxel = figures.spacing;
  return options;
}

Result<points::ParticleField> make_level_set(const points::ParticleSet& particles, const points::FieldOptions& options,
                                             const Context& context) {
  const auto spheres = TRY(points::make_spheres(particles, options, context));
  points::ParticleField made;
  made.figures = spheres.figures();
  points::ParticleFieldStatistics& figures = made.figures;
  if (figures.particles == 0) {
    made.field.kind = field::FieldKind::level_set;
    made.field.samples = field::SparseSamples{};
  } else {
    const volume_io::SphereOptions asked = sphere_options(spheres, options.method);
    auto field = volume_io::rasterize_spheres(spheres.particles(), asked, context);
    if (!field) return tl::unexpected(std::move(field.error()));
    made.field = std::move(field->field);
    made.field.index_to_world.offset += spheres.origin();
    made.region = spheres.region();
    figures.particles_too_small = field->left_out;
    figures.particles -= field->left_out;
    const auto& samples = std::get<field::SparseSamples>(made.field.samples);
    figures.bricks_stored = samples.blocks.size();
    if (figures.particles == 0) {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected particles with a radius of at least {} sample spacings ({:.6g} with a "
                              "spacing of {:.6g}), found {}, all smaller",
                              particles.label, points::kMinSphereRadius, points::kMinSphereRadius * figures.spacing,
                              figures.spacing, counted(field->left_out, "particle")),
                  {Remedy::lower, Setting::cell_size});
    }
  }
  made.field.name = particles.label;
  made.field.source = particles.label;
  made.field.format = "particles";
  return made;
}

bool is_level_set(points::Method method) { return points::method_info(method).kind == field::FieldKind::level_set; }

// Returns the memory that finer samples for small spheres may take. It does not depend on what other conversions use,
// so that the choice is the same in every run.
std::uint64_t memory_for_spheres(const Context& context) { return context.memory().limit() / 4; }

// Returns the finest spacing from SphereSpacings::keeps_most to SphereSpacings::usual that fits memory_for_spheres().
Result<double> finest_spacing(const points::ParticleSet& particles, points::FieldOptions options,
                              const points::SphereSpacings& spacings, const Context& context) {
  double spacing = spacings.keeps_most;
  while (spacing < spacings.usual) {
    options.spacing = spacing;
    const auto spheres = TRY(points::make_spheres(particles, options, context));
    const auto bytes = volume_io::sphere_bytes(spheres.particles(), sphere_options(spheres, options.method), context);
    if (!bytes && bytes.error().code != ErrorCode::out_of_memory) return tl::unexpected(bytes.error());
    if (bytes && *bytes <= memory_for_spheres(context)) break;
    spacing *= std::numbers::sqrt2;
  }
  return std::min(spacing, spacings.usual);
}

// Returns a positive number rounded down to three digits.
double rounded_down(double number) {
  const double step = std::pow(10.0, std::floor(std::log10(number)) - 2);
  return std::floor(number / step) * step;
}

}  // namespace

Result<SphereSpacing> choose_sphere_spacing(const points::ParticleSet& particles, const SourceOptions& source,
                                            const Context& context) {
  const ParticleOptions& options = source.particles;
  points::FieldOptions asked = field_options(source, std::nullopt);
  SphereSpacing chosen;
  if (!is_level_set(options.method)) return chosen;
  const auto found = TRY(points::find_sphere_spacings(particles, asked, context));
  if (!found) return chosen;
  const double cell = points::method_info(options.method).cell_size;
  const auto cells = [&](double spacing) { return spacing / found->usual * cell; };
  double spacing = found->usual;
  std::string reason;
  if (options.cell_size) {
    spacing = *options.cell_size / cell * found->usual;
  } else if (options.sequence_spacing) {
    chosen.spacing = spacing = *options.sequence_spacing;
  } else if (!source.resamples()) {
    chosen.spacing = spacing = TRY(finest_spacing(particles, asked, *found, context));
    if (spacing > found->keeps_most) {
      reason = fmt::format(", but may take more than {}, a quarter of the memory limit",
                           format_byte_size(memory_for_spheres(context)));
    } else if (found->keeps_all < spacing) {
      reason = fmt::format(", but takes cells more than {} times finer than usual", points::kMaxSphereRefinement);
    }
    if (spacing < found->usual) {
      chosen.notes.push_back(
          {NoteId::cell_size,
           fmt::format("the samples are {:.6g} apart, {:.4g} radii instead of {}, so that the surface "
                       "keeps particles of the radius {:.6g}",
                       spacing, cells(spacing), cell, points::kMinSphereRadius * spacing)});
    }
  }
  if (found->keeps_all < spacing) {
    chosen.notes.push_back(
        {NoteId::cell_size,
         fmt::format("the surface will leave out particles with a radius below {:.6g}; a cell size "
                     "of {:.3g} radii keeps all{}",
                     points::kMinSphereRadius * spacing, rounded_down(cells(found->keeps_all)), reason)});
  }
  return chosen;
}

Result<points::ParticleField> make_particle_field(points::ParticleSet& particles, Positions positions,
                                                  const points::FieldOptions& options, const Context& context) {
  const bool of_spheres = is_level_set(options.method);
  auto made = TRY(of_spheres                     ? make_level_set(particles, options, context)
                  : positions == Positions::free ? points::make_field_and_free(particles, options, context)
                                                 : points::make_field(particles, options, context));
  const points::ParticleFieldStatistics& figures = made.figures;
  if (!figures.radius_attribute.empty()) {
    const bool takes_median = options.method == points::Method::weight || options.method == points::Method::anisotropic;
    made.field.notes.push_back(
        {NoteId::particle_radius,
         takes_median ? fmt::format("all particles have the radius {:.6g}, the median of the radii ('{}')",
                                    figures.radius, printable(figures.radius_attribute))
                      : fmt::format("each particle has its own radius ('{}'); the median radius is {:.6g}",
                                    printable(figures.radius_attribute), figures.radius)});
  }
  if (!of_spheres && figures.particles_too_small > 0) {
    made.field.notes.push_back(
        {NoteId::particles_left_out,
         fmt::format("the field omits {} with a radius below {:.3g} sample spacings, which could fall between "
                     "samples",
                     counted(figures.particles_too_small, "particle"), figures.least_radius)});
  }
  if (made.region) {
    // The samples beyond the box repeat those in it.
    field::IndexBox& active = std::get<field::SparseSamples>(made.field.samples).active_box;
    active = {glm::max(active.min, made.region->min), glm::min(active.max, made.region->max)};
  }
  return made;
}

}  // namespace isoextract::convert
