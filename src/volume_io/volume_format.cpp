#include "volume_io/volume_format.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#include "volume_io/detail/formats.hpp"
#include "volume_io/detail/plugin_volumes.hpp"

namespace isoextract::volume_io {

Result<std::vector<files::FilePart>> VolumeFormat::parts(const std::string& input, const ReadOptions& options,
                                                         const Context& context) const {
  const auto paths = TRY(files(input, options, context));
  std::vector<files::FilePart> parts;
  for (const std::filesystem::path& path : paths) parts.push_back({path, {}});
  return parts;
}

std::span<const VolumeFormat* const> volume_formats() {
  static const std::vector<std::unique_ptr<const VolumeFormat>> plugins =
      find_plugin_formats(plugin_host::plugin_folders());
  static const std::vector<const VolumeFormat*> formats = [] {
    std::vector<const VolumeFormat*> all{
        &vdb_format(),    //
        &nrrd_format(),   //
        &nifti_format(),  //
        &npy_format(),    //
        &npz_format(),    //
        &raw_format(),    //
        &raw_header_format(), &demo_format(),
    };
    for (const auto& plugin : plugins) {
      const auto same = [&](const VolumeFormat* format) { return format->about().id == plugin->about().id; };
      if (std::ranges::none_of(all, same)) all.push_back(plugin.get());
    }
    return all;
  }();
  return formats;
}

const VolumeFormat* find_volume_format(std::string_view id) {
  for (const VolumeFormat* format : volume_formats()) {
    if (format->about().id == id) return format;
  }
  return nullptr;
}

}  // namespace isoextract::volume_io
