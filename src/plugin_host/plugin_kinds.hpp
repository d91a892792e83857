// The kinds of plug-ins that read files.
#pragma once

#include "plugin_host/plugin_library.hpp"

namespace isoextract::plugin_host {

extern const PluginKind kVolumePlugins;
extern const PluginKind kParticlePlugins;

// The id of all plug-ins around OpenVDB. They have no volume format of their own: the built-in VDB reader calls them
// for grids it does not read itself.
inline constexpr const char* kOpenVdbPlugin = "openvdb";

}  // namespace isoextract::plugin_host
