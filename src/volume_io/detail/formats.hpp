// The built-in formats.
#pragma once

#include <memory>

#include "plugin_host/plugin_library.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

[[nodiscard]] const VolumeFormat& vdb_format();
// Returns the VDB format with plug-ins from other folders.
[[nodiscard]] std::unique_ptr<const VolumeFormat> make_vdb_format(plugin_host::PluginFolders folders);
[[nodiscard]] const VolumeFormat& nrrd_format();
[[nodiscard]] const VolumeFormat& nifti_format();
[[nodiscard]] const VolumeFormat& npy_format();
[[nodiscard]] const VolumeFormat& npz_format();
[[nodiscard]] const VolumeFormat& raw_format();
[[nodiscard]] const VolumeFormat& raw_header_format();
[[nodiscard]] const VolumeFormat& demo_format();

}  // namespace isoextract::volume_io
