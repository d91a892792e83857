// Particle formats read by plug-ins (plugins/particle_plugin.h). VTK and OpenVDB are known without their plug-ins, so
// that their files are recognized even if the plug-ins are missing.
#pragma once

#include <memory>
#include <vector>

#include "particle_io/detail/particle_source.hpp"
#include "plugin_host/plugin_library.hpp"

namespace isoextract::particle_io {

// Makes the formats of VTK, OpenVDB, and the tables in the folders. They also fail with ErrorCode::unavailable (see
// PluginLibrary::opened).
[[nodiscard]] std::vector<std::unique_ptr<const ParticleFormat>> find_particle_plugins(
    const plugin_host::PluginFolders& folders);

}  // namespace isoextract::particle_io
