// Checks the options of outputs that hold the particles themselves instead of their surfaces.
#pragma once

#include <array>
#include <optional>

#include "base/error.hpp"
#include "cli/field_plan.hpp"
#include "cli/options.hpp"
#include "particle_io/particle_writer.hpp"

namespace isoextract::cli {

// The formats that -o and --format choose; their words are also the extensions, without the dot. The list omits formats
// whose extension meshes or fields use (ply, npy).
inline constexpr std::array kParticleFileFormats{
    particle_io::ParticleFileFormat::bgeo, particle_io::ParticleFileFormat::vtu, particle_io::ParticleFileFormat::xyz};

// Returns the format if the output is the particles (by --format, or else by the extension of -o), else nullopt.
[[nodiscard]] std::optional<particle_io::ParticleFileFormat> particle_file_format(const ConvertFlags& flags);
[[nodiscard]] inline bool writes_particles(const ConvertFlags& flags) {
  return particle_file_format(flags).has_value();
}

// Returns whether the output is made of surfaces, which have iso values.
[[nodiscard]] inline bool makes_surfaces(const ConvertFlags& flags) {
  return !writes_field(flags) && !writes_particles(flags);
}

// Fails with ErrorCode::usage if the output is the particles, and an option needs a field or a surface (About::surface
// except --roi, --nan hole) or -o contains {iso}.
[[nodiscard]] Result<void> check_particle_file_options(const ConvertFlags& flags);

}  // namespace isoextract::cli
