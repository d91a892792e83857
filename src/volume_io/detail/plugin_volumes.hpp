// Volume formats read by plug-ins (plugins/volume_plugin.h). Tables beside the plug-ins list them; a plug-in is opened
// for the first file of its format and stays open.
#pragma once

#include <memory>
#include <vector>

#include "plugin_host/plugin_library.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// Makes the format with the description's id, without reading tables.
[[nodiscard]] std::unique_ptr<const VolumeFormat> make_plugin_format(FormatDescription about,
                                                                     plugin_host::PluginFolders folders);

// Makes the formats of the tables in the folders, by folder and then by id; of several tables with one id, only the
// first counts. Skips kOpenVdbPlugin. These formats also fail with ErrorCode::unavailable if their plug-in is in none
// of the folders, cannot be opened, or has another version.
[[nodiscard]] std::vector<std::unique_ptr<const VolumeFormat>> find_plugin_formats(
    const plugin_host::PluginFolders& folders);

}  // namespace isoextract::volume_io
