// The plug-in for Zarr: volumes of OME-Zarr and other hierarchies, in a folder or a ZIP file.
#include <filesystem>

#include "zarr_volume.hpp"

namespace isoextract_zarr {
namespace {

std::unique_ptr<isoextract_plugin::VolumeFile> open_zarr(const isoextract_plugin::Request& request,
                                                         const isoextract_plugin_host& host) {
  isoextract_plugin::HostMemory memory(host);
  auto store = open_store(request.path, memory);
  auto file = open_hierarchy(std::move(store), request.volume, request.level, host);
  memory.keep();  // until the host frees the list, and with it the store
  return file;
}

bool may_be_zarr(const unsigned char* start, std::size_t bytes, const std::string& path) {
  if (is_metadata_name(std::filesystem::path(path).filename().string())) return true;
  return bytes >= 2 && start[0] == 'P' && start[1] == 'K' && zip_has_metadata(path);
}

}  // namespace
}  // namespace isoextract_zarr

const isoextract_volume_plugin_v4* isoextract_volume_plugin() {
  static const isoextract_volume_plugin_v4 kTable =
      isoextract_plugin::volume_plugin<isoextract_zarr::open_zarr, isoextract_zarr::may_be_zarr>("zarr", "Zarr");
  return &kTable;
}
