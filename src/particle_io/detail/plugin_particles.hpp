// Formats of particles that plug-ins read (plugins/particle_plugin.h). Those of VTK and OpenVDB are known without
// their plug-ins, so that their files can be told from others where those are missing.
#pragma once

#include <memory>
#include <vector>

#include "particle_io/detail/particle_source.hpp"
#include "plugin_host/plugin_library.hpp"

namespace isoextract::particle_io {

// VTK, OpenVDB, and what the tables in the folders say. Besides the errors of all formats theirs are
// ErrorCode::unavailable (PluginLibrary::opened).
[[nodiscard]] std::vector<std::unique_ptr<const ParticleFormat>> find_particle_plugins(
    const plugin_host::PluginFolders& folders);

}  // namespace isoextract::particle_io
