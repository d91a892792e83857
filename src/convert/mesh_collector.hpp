// Collects the meshes of a conversion instead of writing them to files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "convert/source.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_packing.hpp"

namespace isoextract::convert {

struct MeshCollector {
  // Set by the caller. The conversion first checks that it may write the job's files; the caller writes them later.
  bool checks_files = true;
  // Set by the caller. The conversion hands over its source, whose samples are valid everywhere, not only near the
  // surfaces.
  bool wants_source = false;
  // Set by the caller: the meshes become a file of the job's format, so notes about the format apply.
  bool becomes_file = false;

  // The surfaces of all outputs in order, finished as if they were written: placed, simplified, verified.
  // With PieceChoice::split, one mesh for each body. Surfaces that EmptyPolicy::skip leaves out are missing,
  // and no old file is removed. With several iso values, each mesh's name contains its iso value. The meshes
  // keep their memory reservations.
  std::vector<mesh::Mesh> meshes = {};
  std::vector<SurfaceId> ids = {};    // of each mesh
  mesh_io::MeshPacking packing = {};  // how the meshes are to be packed
  std::string placement = {};         // see mesh_io::MeshWriteOptions::placement
  std::optional<Source> source = {};  // the surfaces' source, if wants_source and the conversion succeeded
};

}  // namespace isoextract::convert
