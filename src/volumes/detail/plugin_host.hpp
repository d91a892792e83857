// Formats that plug-ins read (plugins/volume_plugin.h). Which there are is known from tables beside them; a plug-in
// itself is opened when a file of its format comes, and stays open.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "volumes/volume_format.hpp"

namespace isoextract::volumes {

// Where plug-ins are looked for, in this order: ISOEXTRACT_PLUGINS, `plugins` beside the program, and
// `../lib/isoextract/plugins` from there. They need not exist.
[[nodiscard]] std::vector<std::filesystem::path> plugin_folders();

// What the tables in the folders say, by folder and then by name; the first of an id counts. Besides the errors of all
// formats theirs are ErrorKind::unavailable: the plug-in is in none of the folders, cannot be opened, or is of another
// version.
[[nodiscard]] std::vector<std::unique_ptr<const VolumeFormat>> find_plugin_formats(
    const std::vector<std::filesystem::path>& folders);

}  // namespace isoextract::volumes
