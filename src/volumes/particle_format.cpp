#include "volumes/particle_format.hpp"

#include "volumes/particles/particle_source.hpp"

namespace isoextract::volumes {

const std::vector<const ParticleFormat*>& particle_formats() {
  static const std::vector<const ParticleFormat*> formats{
      &ply_particles(),     //
      &lammps_particles(),  //
      &bgeo_particles(),    //
      &npy_particles(),     //
      &xyz_particles(),     //
      &csv_particles(),     //
  };
  return formats;
}

std::vector<ParticleFormatDescription> particle_format_descriptions() {
  std::vector<ParticleFormatDescription> all;
  for (const ParticleFormat* format : particle_formats()) all.push_back(format->about());
  return all;
}

}  // namespace isoextract::volumes
