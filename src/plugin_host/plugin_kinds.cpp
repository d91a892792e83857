#include "plugin_host/plugin_kinds.hpp"

#include <particle_plugin.h>
#include <volume_plugin.h>

namespace isoextract::plugin_host {

const PluginKind kVolumePlugins{"isoextract-volume-", "isoextract_volume_plugin",
                                call_plugin_function<isoextract_volume_plugin_v4>, ISOEXTRACT_VOLUME_PLUGIN_VERSION};

const PluginKind kParticlePlugins{"isoextract-particles-", "isoextract_particle_plugin",
                                  call_plugin_function<isoextract_particle_plugin_v3>,
                                  ISOEXTRACT_PARTICLE_PLUGIN_VERSION};

const PluginKind kUnpackPlugins{"isoextract-unpack-", "isoextract_volume_plugin",
                                call_plugin_function<isoextract_volume_plugin_v4>, ISOEXTRACT_VOLUME_PLUGIN_VERSION};

}  // namespace isoextract::plugin_host
