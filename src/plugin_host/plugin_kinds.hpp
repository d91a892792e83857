// The kinds of plug-ins that read files.
#pragma once

#include "plugin_host/plugin_library.hpp"

namespace isoextract::plugin_host {

extern const PluginKind kVolumePlugins;
extern const PluginKind kParticlePlugins;
// Reads no volumes, but has their interface (unpacked_input.hpp).
extern const PluginKind kUnpackPlugins;

// The id of all plug-ins that use OpenVDB. The one for volumes has no format of its own: the built-in VDB reader calls
// it for grids that it does not read itself.
inline constexpr const char* kOpenVdbPlugin = "openvdb";

}  // namespace isoextract::plugin_host
