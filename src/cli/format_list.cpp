#include "cli/format_list.hpp"

#include <fmt/format.h>

#include "mesh_io/mesh_writer.hpp"
#include "particle_io/particle_format.hpp"
#include "plugin_host/plugin_kinds.hpp"
#include "volume_io/grid_tools.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::cli {
namespace {

void add_volumes(std::vector<ListedFormat>& formats) {
  for (const volume_io::VolumeFormat* format : volume_io::volume_formats()) {
    const volume_io::FormatDescription& about = format->about();
    std::string title = about.title;
    if (about.needs_layout) title += ", with --dims and --dtype";
    formats.push_back({FormatUse::read_volume, about.id, std::move(title), about.extensions, about.library,
                       about.is_plugin, about.plugin, about.package});
  }
}

void add_particles(std::vector<ListedFormat>& formats) {
  for (const particle_io::ParticleFormatDescription& about : particle_io::particle_format_descriptions()) {
    std::string title = about.title;
    if (about.has_frames) title += "; a file may hold several frames";
    formats.push_back({FormatUse::read_particles, about.id, std::move(title), about.extensions, about.library,
                       about.is_plugin, about.plugin, about.package});
  }
}

void add_packed(std::vector<ListedFormat>& formats) {
  const plugin_host::PluginFolders folders = plugin_host::plugin_folders();
  for (const plugin_host::PluginTable& table :
       plugin_host::find_plugin_tables(folders, plugin_host::kUnpackPlugins.name_start)) {
    const plugin_host::PluginLibrary library(plugin_host::kUnpackPlugins, table.id, folders);
    formats.push_back({FormatUse::unpack, table.id, table.title, table.extensions, table.library, true, library.path(),
                       table.package});
  }
}

void add_meshes(std::vector<ListedFormat>& formats) {
  for (const mesh_io::MeshFormatInfo& info : mesh_io::mesh_formats()) {
    std::string title(info.title);
    title += info.can_hold_several_meshes ? "; several surfaces a file" : "; one surface a file";
    if (!info.can_stream) title += "; not to stdout";
    const std::string library = mesh_io::is_gltf(info.format)             ? "tinygltf"
                                : info.format == mesh_io::MeshFormat::drc ? "Draco"
                                                                          : "";
    formats.push_back(
        {FormatUse::write_mesh, std::string(info.name), std::move(title), {fmt::format(".{}", info.name)}, library});
  }
}

}  // namespace

std::vector<ListedFormat> list_formats() {
  std::vector<ListedFormat> formats;
  add_volumes(formats);
  add_particles(formats);
  add_packed(formats);
  add_meshes(formats);
  const auto add = [&](FormatUse use, const char* id, const char* title, const char* library) {
    formats.push_back({use, id, title, {fmt::format(".{}", id)}, library});
  };
  formats.push_back({FormatUse::write_field,
                     "vdb",
                     "OpenVDB, one grid of floats, or with --half of 16-bit ones",
                     {".vdb"},
                     "OpenVDB",
                     true,
                     volume_io::grid_tools_path(),
                     "libopenvdb-dev"});
  add(FormatUse::write_field, "nrrd", "NRRD with the transform, dense, in the type of the samples", "");
  add(FormatUse::write_field, "npy",
      "NumPy array [z, y, x], dense; without spacing and origin; 16-bit floats with --half", "");
  add(FormatUse::write_field, "vti", "VTK image data with appended raw samples, dense", "");
  add(FormatUse::write_particles, "bgeo", "Houdini geometry, with words such as species", "");
  add(FormatUse::write_particles, "vtu", "VTK unstructured grid, numbers only", "");
  add(FormatUse::write_particles, "xyz", "extended XYZ, text, with words and the box", "");
  return formats;
}

}  // namespace isoextract::cli
