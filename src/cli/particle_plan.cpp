#include "cli/particle_plan.hpp"

#include <utility>

#include <fmt/format.h>

#include "cli/plan.hpp"
#include "cli/plan_parts.hpp"
#include "convert/particle_source.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::cli {
namespace {

// Refuses options that have no effect with the method.
Result<void> check_method(const ParticleFlags& flags, points::Method method, bool has_attributes) {
  const bool weighs = method == points::Method::weight;
  if (!weighs) {
    TRY(flags.refuse(About::weights, fmt::format("{{}} needs --particles weight, found the method {}", word_of(method)),
                     "give --particles weight"));
  }
  // Attributes are interpolated with these kernels by every method.
  if (!points::has_kernels(method) && flags.smoothing_length && !has_attributes) {
    return refuse_usage(
        fmt::format("--smoothing-length sets the size of kernels, and --particles {} uses no kernels", word_of(method)),
        "use --particles sph, anisotropic or smooth");
  }
  return {};
}

// Joins the conditions of --select, --type and --species.
std::optional<std::string> joined_conditions(const ParticleFlags& flags) {
  std::vector<std::string> conditions;
  for (const Value<std::string>* flag : {&flags.select, &flags.types, &flags.species}) {
    if (flag->is_set()) conditions.push_back(**flag);
  }
  if (conditions.size() < 2) return conditions.empty() ? std::nullopt : std::optional(conditions.front());
  std::string joined;
  for (const std::string& condition : conditions) {
    joined += fmt::format("{}({})", joined.empty() ? "" : " && ", condition);
  }
  return joined;
}

}  // namespace

Result<convert::ParticleOptions> plan_particles(const ParticleFlags& flags, std::optional<extract::NanPolicy> nan,
                                                bool has_attributes) {
  convert::ParticleOptions options;
  options.expected = flags.any_set();
  options.method = flags.method.value_or(options.method);
  TRY(check_method(flags, options.method, has_attributes));
  if (options.expected && nan == extract::NanPolicy::hole) {
    return refuse_usage("--nan hole applies to samples of a volume, not to particles",
                        "use --nan outside to skip particles with NaN positions");
  }
  options.non_finite =
      nan == extract::NanPolicy::outside ? points::NonFiniteParticles::skip : points::NonFiniteParticles::error;
  TRY(refuse_both(flags.radius, flags.radii));
  if (flags.radius) options.radius = flags.radius->radius;
  options.element_radii = flags.radii;
  options.cell_size = flags.cell_size;
  options.smoothing_length = flags.smoothing_length.value_or(options.smoothing_length);
  options.weight = flags.weight.value_or(options.weight);
  options.deposit = flags.deposit.value_or(options.deposit);
  options.columns = flags.columns;
  options.stride = flags.stride.value_or(options.stride);
  options.select = joined_conditions(flags);
  convert::BoxOptions& box = options.simulation_box;
  box = {.bounds = flags.box, .periodic = flags.periodic, .unwrap = flags.unwrap};
  if (box.unwrap && box.is_periodic()) {
    return refuse_usage("--unwrap and --periodic contradict each other: unwrapped particles belong to no period",
                        "leave one of them out");
  }
  return options;
}

bool has_attributes(const ConvertFlags& flags) {
  return !flags.attributes.empty() || (flags.color && flags.color->attribute);
}

Result<std::string> set_default_iso(ConvertFlags& flags, const std::string& input, const Context& context) {
  if (!flags.isos.empty()) return std::string();
  auto read = TRY(plan_read(flags.input));
  auto particles = TRY(plan_particles(flags.particles, flags.surface.nan, has_attributes(flags)));
  const bool expected = particles.expected;
  const points::MethodInfo& method = points::method_info(particles.method);
  if (!expected) {
    const auto take_zero = [&] {
      flags.isos = {convert::IsoChoice::zero_by_default()};
      return std::string();
    };
    if (files::is_standard_input(input) && !read.format) return take_zero();
    convert::SourceOptions source;
    source.input = input;
    source.read = std::move(read);
    source.particles = std::move(particles);
    const auto of_particles = convert::is_particles(source, context.beside());
    if (!of_particles && of_particles.error().code == ErrorCode::usage) return tl::unexpected(of_particles.error());
    if (!of_particles.value_or(false)) return take_zero();  // the reader reports files that cannot be read
  }
  flags.isos.emplace_back(method.iso);
  return fmt::format("iso {}, the default of {}; choose another with --iso V", method.iso, method.title);
}

}  // namespace isoextract::cli
