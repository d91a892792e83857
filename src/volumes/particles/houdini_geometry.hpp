// Points of Houdini's geometry files since version 12: arrays of names and values in binary JSON.
#pragma once

#include "volumes/particles/particle_columns.hpp"

namespace isoextract::volumes {

// As ParticleFormat::info and read. Throw DamagedParticles and Refused.
[[nodiscard]] ParticleInfo houdini_info(const files::InputFile& file, const ParticleReadOptions& options);
[[nodiscard]] ParticleFile read_houdini(const files::InputFile& file, const ParticleReadOptions& options);

}  // namespace isoextract::volumes
