#include "particle_io/particle_format.hpp"

#include <algorithm>
#include <memory>

#include "base/ascii.hpp"
#include "files/unpacked_files.hpp"
#include "particle_io/detail/particle_source.hpp"
#include "particle_io/detail/plugin_particles.hpp"

namespace isoextract::particle_io {

const std::vector<const ParticleFormat*>& particle_formats() {
  static const std::vector<std::unique_ptr<const ParticleFormat>> plugins =
      find_particle_plugins(plugin_host::plugin_folders());
  static const std::vector<const ParticleFormat*> formats = [] {
    std::vector<const ParticleFormat*> all{
        &ply_particles(),     //
        &lammps_particles(),  //
        &bgeo_particles(),    //
        &npy_particles(),     //
        &xyz_particles(),     //
        &csv_particles(),     //
        &gro_particles(),     //
        &pdb_particles(),     //
    };
    for (const auto& plugin : plugins) {
      const auto same = [&](const ParticleFormat* format) { return format->about().id == plugin->about().id; };
      if (std::ranges::none_of(all, same)) all.push_back(plugin.get());
    }
    return all;
  }();
  return formats;
}

std::vector<ParticleFormatDescription> particle_format_descriptions() {
  std::vector<ParticleFormatDescription> all;
  for (const ParticleFormat* format : particle_formats()) all.push_back(format->about());
  return all;
}

bool has_particle_extension(const std::filesystem::path& path) {
  const std::string name = to_lower(files::name_without_packing(path.filename().string()));
  const auto claims = [&](const std::string& extension) { return name.ends_with(extension); };
  return std::ranges::any_of(particle_formats(), [&](const ParticleFormat* format) {
    return std::ranges::any_of(format->about().extensions, claims);
  });
}

}  // namespace isoextract::particle_io
