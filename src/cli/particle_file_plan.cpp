#include "cli/particle_file_plan.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/plan_parts.hpp"

namespace isoextract::cli {

std::optional<particle_io::ParticleFileFormat> particle_file_format(const ConvertFlags& flags) {
  if (flags.format) return flags.format->particles;
  if (!flags.output) return std::nullopt;
  const auto format = particle_io::particle_file_format_by_path(*flags.output);
  return format && std::ranges::find(kParticleFileFormats, *format) != kParticleFileFormats.end() ? format
                                                                                                  : std::nullopt;
}

Result<void> check_particle_file_options(const ConvertFlags& flags) {
  if (!writes_particles(flags)) return {};
  const ParticleFlags& particles = flags.particles;
  const SurfaceFlags& surface = flags.surface;
  std::vector<std::string_view> given;
  for (const Option* option : flags.set_about(About::surface)) {
    if (option != &surface.roi) given.push_back(option->name());
  }
  const std::array<const Option*, 12> of_fields{&particles.method,    &particles.radius,   &particles.smoothing_length,
                                                &particles.cell_size, &particles.weight,   &particles.deposit,
                                                &surface.resolution,  &surface.voxel_size, &surface.kernel,
                                                &surface.filters,     &surface.blurs,      &flags.half};
  for (const Option* option : of_fields) {
    const bool is_listed = std::ranges::find(given, option->name()) != given.end();
    if (!is_listed && !option->texts().empty()) given.push_back(option->name());
  }
  if (!given.empty()) {
    const std::string names = fmt::format("{}", fmt::join(given, ", "));
    return refuse_usage(fmt::format("{} {} a surface or a field, but the output is the particles", names,
                                    given.size() == 1 ? "needs" : "need"),
                        fmt::format("leave {} out, or give the output a name of a mesh or field format", names));
  }
  if (surface.nan == extract::NanPolicy::hole) {
    return refuse_usage("--nan hole needs a surface, but the output is the particles",
                        "use --nan outside to leave out particles with NaN positions");
  }
  if (flags.output && flags.output->find("{iso}") != std::string::npos) {
    return refuse_usage(fmt::format("-o {}: particles have no iso value", *flags.output), "leave {iso} out");
  }
  return {};
}

}  // namespace isoextract::cli
