// The kinds of plug-ins that read files.
#pragma once

#include "plugin_host/plugin_library.hpp"

namespace isoextract::plugin_host {

extern const PluginKind kVolumePlugins;
extern const PluginKind kParticlePlugins;

// The id of the plug-ins around OpenVDB, of any kind. They have no format of volumes of their own: the built-in one
// asks them for what it does not read itself.
inline constexpr const char* kOpenVdbPlugin = "openvdb";

}  // namespace isoextract::plugin_host
