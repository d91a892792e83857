#include "convert/particle_field.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "points/sphere_set.hpp"
#include "volume_io/grid_tools.hpp"

namespace isoextract::convert {
namespace {

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
    volume_io::SphereOptions asked;
    const bool is_smooth = options.method == points::Method::smooth;
    asked.method = is_smooth ? volume_io::SphereMethod::smooth : volume_io::SphereMethod::spheres;
    asked.radius = figures.radius;
    asked.radii = spheres.radii();
    asked.images = spheres.images();
    asked.search_radius = figures.support;
    asked.voxel = figures.spacing;
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
                              "spacing of {:.6g}), found {} particles, all smaller",
                              particles.label, points::kMinSphereRadius, points::kMinSphereRadius * figures.spacing,
                              figures.spacing, field->left_out),
                  {{Remedy::lower, Setting::cell_size}, {Remedy::raise, Setting::radius}});
    }
  }
  made.field.name = particles.label;
  made.field.source = particles.label;
  made.field.format = "particles";
  return made;
}

}  // namespace

Result<points::ParticleField> make_particle_field(points::ParticleSet& particles, Positions positions,
                                                  const points::FieldOptions& options, const Context& context) {
  const bool is_level_set = points::method_info(options.method).kind == field::FieldKind::level_set;
  auto made = TRY(is_level_set                   ? make_level_set(particles, options, context)
                  : positions == Positions::free ? points::make_field_and_free(particles, options, context)
                                                 : points::make_field(particles, options, context));
  const points::ParticleFieldStatistics& figures = made.figures;
  if (!figures.radius_attribute.empty()) {
    const bool takes_median = options.method == points::Method::weight || options.method == points::Method::anisotropic;
    made.field.notes.push_back(
        {NoteId::particle_radius,
         takes_median ? fmt::format("all particles have the radius {:.6g}, the median of the attribute '{}'",
                                    figures.radius, printable(figures.radius_attribute))
                      : fmt::format("the attribute '{}' gives the radius of each particle; the median radius is {:.6g}",
                                    printable(figures.radius_attribute), figures.radius)});
  }
  if (!is_level_set && figures.particles_too_small > 0) {
    made.field.notes.push_back(
        {NoteId::particles_left_out,
         fmt::format(
             "the field omits {} particles with a radius below {:.3g} sample spacings, which could fall between "
             "samples",
             figures.particles_too_small, figures.least_radius)});
  }
  if (made.region) {
    // The samples beyond the box repeat those in it.
    field::IndexBox& active = std::get<field::SparseSamples>(made.field.samples).active_box;
    active = {glm::max(active.min, made.region->min), glm::min(active.max, made.region->max)};
  }
  return made;
}

}  // namespace isoextract::convert
