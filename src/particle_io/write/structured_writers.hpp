// Particle files with one array per attribute. Names are checked by the caller (particle_writer.hpp).
#pragma once

#include "base/error.hpp"
#include "files/output_file.hpp"
#include "points/particle_set.hpp"

namespace isoextract::particle_io {

// Writes Houdini geometry (since version 12) in binary JSON: P as fpreal64, attributes as fpreal32, words as
// strings, no primitives.
[[nodiscard]] Result<void> write_bgeo(files::OutputFile& file, const points::ParticleSet& particles);

// Writes an unstructured grid of VTK with a vertex cell per particle, as XML with appended raw arrays.
[[nodiscard]] Result<void> write_vtu(files::OutputFile& file, const points::ParticleSet& particles);

}  // namespace isoextract::particle_io
