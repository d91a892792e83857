// Opens a hierarchy as volumes of the plug-in interface.
#pragma once

#include <cstdint>
#include <memory>

#include "volume_reader.hpp"
#include "zarr_store.hpp"

namespace isoextract_zarr {

// `volume` and `level` are those of isoextract_volume_request.
[[nodiscard]] std::unique_ptr<isoextract_plugin::VolumeFile> open_hierarchy(std::unique_ptr<Store> store,
                                                                            std::uint64_t volume, std::uint64_t level,
                                                                            const isoextract_plugin_host& host);

}  // namespace isoextract_zarr
