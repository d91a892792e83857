#include "points/sphere_set.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "points/detail/box_samples.hpp"
#include "points/detail/field_lengths.hpp"
#include "points/detail/particle_radii.hpp"
#include "points/detail/periodic_images.hpp"

namespace isoextract::points {
namespace {

// Returns the radii of the particles at finite positions.
Result<std::shared_ptr<ReservedBuffer<float>>> radii_of(const ParticleSet& particles, const ParticleAttribute& radii,
                                                        std::uint64_t finite, const Context& context) {
  auto kept = make_reserved_buffer<float>(finite, context, particles.label + ": radii of particles");
  if (!kept) return kept;
  std::size_t n = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (is_finite(particles.positions[i])) (*kept)->values[n++] = radii.values[i];
  }
  return kept;
}

Result<std::shared_ptr<const ParticleSet>> finite_ones(const ParticleSet& particles, std::uint64_t finite,
                                                       const Context& context) {
  auto memory = TRY(context.reserve(finite * sizeof(glm::dvec3), particles.label + ": positions of particles"));
  auto kept = std::make_shared<ParticleSet>();
  kept->label = particles.label;
  kept->positions = Buffer<glm::dvec3>(finite);
  kept->memory = std::move(memory);
  std::copy_if(particles.positions.begin(), particles.positions.end(), kept->positions.begin(),
               [](const glm::dvec3& p) { return is_finite(p); });
  return kept;
}

}  // namespace

bool has_radius_attribute(const ParticleSet& particles) { return radius_attribute(particles) != nullptr; }

// Uses samples at multiples of the spacing from the origin of the box, as OpenVDB has them.
Result<void> SphereSet::repeat(const SimulationBox& box, const FieldOptions& options, const Context& context) {
  const std::string label = particles().label;
  const auto refused = [&](const std::string& expected) {
    return fail(ErrorCode::input,
                fmt::format("{}: the method {} needs a periodic box with {}; found the box {}, periodic along {}",
                            label, method_info(options.method).title, expected, box_text(box), periodic_text(box)),
                {{Remedy::set, Setting::particle_method, "sph, which works in every periodic box"},
                 {Remedy::set, Setting::periodic_edges, "none to convert the particles without periods"}});
  };
  if (!box.is_upright() || box.edges[0].x < 0 || box.edges[1].y < 0 || box.edges[2].z < 0) {
    return refused("edges along the axes");
  }
  const auto spacing = common_spacing(box, figures_.spacing);
  if (!spacing) return refused("edges that are multiples of one sample spacing");
  figures_.spacing = *spacing;
  const auto samples = TRY(BoxSamples::make(box, *spacing, label));
  const double common = figures_.radius;
  const double largest = radii_.empty() ? common : static_cast<double>(*std::ranges::max_element(radii_));
  // A sample depends on the particles within the support and on their neighbors; the narrow band is 3 samples wide.
  // Smooth spheres reach at least twice their radius.
  const double kernel = figures_.support > 0 ? std::max(figures_.support, 2 * largest) : 0;
  const double reach = (largest + 2 * kernel) / *spacing + 3;
  const auto all =
      TRY(with_images(particles().positions.span(), samples, reach_of_images(glm::dvec3(reach), options.margin),
                      Coordinates::cartesian, context, label));
  const std::size_t originals = particles().size();
  const auto radius_of = [&](std::size_t i) { return radii_.empty() ? common : static_cast<double>(radii_[i]); };
  const auto is_kept = [&](std::size_t place) {
    return place < originals || radius_of(all.sources->values[place]) >= kMinSphereRadius * *spacing;
  };
  std::size_t count = 0;
  for (std::size_t place = 0; place < all.positions().size(); ++place) count += is_kept(place) ? 1 : 0;
  auto memory = TRY(context.reserve(count * sizeof(glm::dvec3), label + ": positions of particles"));
  auto repeated = std::make_shared<ParticleSet>();
  repeated->label = label;
  repeated->positions = Buffer<glm::dvec3>(count);
  repeated->memory = std::move(memory);
  auto radii = TRY(make_reserved_buffer<float>(radii_.empty() ? 0 : count, context, label + ": radii of particles"));
  std::size_t next = 0;
  for (std::size_t place = 0; place < all.positions().size(); ++place) {
    if (!is_kept(place)) continue;
    if (!radii_.empty()) radii->values[next] = radii_[all.sources->values[place]];
    repeated->positions[next++] = *spacing * all.positions()[place];
  }
  kept_ = std::move(repeated);
  if (!radii_.empty()) {
    radii_ = std::as_const(radii->values).span();
    kept_radii_ = std::move(radii);
  }
  region_ = samples.region();
  origin_ = box.origin;
  images_ = count - originals;
  return {};
}

Result<std::optional<SphereSpacings>> find_sphere_spacings(const ParticleSet& particles, const FieldOptions& options,
                                                           const Context& context) {
  TRY(check_options(options));
  const ParticleBounds bounds = measure_bounds(particles.positions.span());
  const auto radii = TRY(find_radii(particles, options, bounds, context));
  if (!radii || !(radii->median > 0)) return std::nullopt;
  // Rounding must not make a sphere smaller than kMinSphereRadius samples.
  const auto spacing_of = [](double radius) { return radius / kMinSphereRadius * (1 - 1e-9); };
  SphereSpacings found;
  found.usual = method_info(options.method).cell_size * radii->median;
  const double smallest_kept = kMinSphereRadius * found.usual / kMaxSphereRefinement;
  double smallest = radii->max;
  double kept = radii->max;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const auto radius = static_cast<double>(radii->attribute->values[i]);
    if (!is_finite(particles.positions[i]) || !(radius > 0)) continue;
    smallest = std::min(smallest, radius);
    if (radius >= smallest_kept) kept = std::min(kept, radius);
  }
  found.keeps_all = spacing_of(smallest);
  found.keeps_most = std::min(found.usual, spacing_of(kept));
  return found;
}

Result<SphereSet> make_spheres(const ParticleSet& particles, const FieldOptions& options, const Context& context) {
  TRY(check_options(options));
  const ParticleBounds bounds = measure_bounds(particles.positions.span());
  TRY(check_positions(particles, bounds, options.non_finite));
  SphereSet spheres(particles);
  ParticleFieldStatistics& figures = spheres.figures_;
  figures.particles = bounds.finite;
  figures.particles_dropped = bounds.not_finite;
  if (bounds.not_finite > 0) {
    spheres.kept_ = TRY(finite_ones(particles, bounds.finite, context));
  }
  if (bounds.finite == 0) return spheres;
  if (const auto found = TRY(find_radii(particles, options, bounds, context))) {
    auto radii = TRY(radii_of(particles, *found->attribute, bounds.finite, context));
    figures.radius = found->median;
    figures.radius_attribute = found->attribute->name;
    spheres.radii_ = radii->values.span();
    spheres.kept_radii_ = std::move(radii);
  }
  TRY(resolve_lengths(particles, options, figures, context));
  if (particles.box && particles.box->is_periodic()) {
    TRY(spheres.repeat(*particles.box, options, context));
  }
  return spheres;
}

}  // namespace isoextract::points
