// Collects the meshes of a conversion where they are not written to its files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "convert/source.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_packing.hpp"

namespace isoextract::convert {

struct MeshCollector {
  // Set by the caller. Whether the conversion first checks that it may write the job's files, to which the meshes go
  // later; and whether it hands over its source, with samples that are right also away from the surfaces.
  bool checks_files = true;
  bool wants_source = false;

  // The surfaces of all outputs, in the order of these, as they would be written: placed, simplified, verified. Those
  // that EmptyPolicy::skip leaves out are not among them, and no old file is removed. Where there are several iso
  // values, each mesh is named after its own. The meshes keep what they have reserved.
  std::vector<mesh::Mesh> meshes = {};
  std::vector<SurfaceId> ids = {};    // one a mesh
  mesh_io::MeshPacking packing = {};  // how they are to be packed
  std::string placement = {};         // mesh_io::MeshWriteOptions has it
  std::optional<Source> source = {};  // of the surfaces, where it was asked for and the conversion did not fail
};

}  // namespace isoextract::convert
