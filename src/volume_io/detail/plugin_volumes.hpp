// Formats that plug-ins read (plugins/volume_plugin.h). Which there are is known from tables beside them; a plug-in
// itself is opened when a file of its format comes, and stays open.
#pragma once

#include <memory>
#include <vector>

#include "plugin_host/plugin_library.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// One format, which is the description's id, without a look at tables.
[[nodiscard]] std::unique_ptr<const VolumeFormat> make_plugin_format(FormatDescription about,
                                                                     plugin_host::PluginFolders folders);

// What the tables in the folders say, by folder and then by name; the first of an id counts. kOpenVdbPlugin
// is left out. Besides the errors of all
// formats theirs are ErrorCode::unavailable: the plug-in is in none of the folders, cannot be opened, or is of another
// version.
[[nodiscard]] std::vector<std::unique_ptr<const VolumeFormat>> find_plugin_formats(
    const plugin_host::PluginFolders& folders);

}  // namespace isoextract::volume_io
