// The kinds of plug-ins that read files.
#pragma once

#include "plugin_host/plugin_library.hpp"

namespace isoextract::plugin_host {

extern const PluginKind kVolumePlugins;
extern const PluginKind kParticlePlugins;
// Plug-ins that unpack archives: they have the interface for volumes, but read none (unpacked_input.hpp).
extern const PluginKind kUnpackPlugins;

// The id of all plug-ins that use OpenVDB. The plug-in for volumes is not a format of its own: the built-in VDB reader
// calls it for the grids that this reader does not support.
inline constexpr const char* kOpenVdbPlugin = "openvdb";

}  // namespace isoextract::plugin_host
