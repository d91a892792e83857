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
  // What its owner asks for.
  bool checks_files =
      true;  // the meshes go to the job's files later: the conversion first checks that it may write them
  bool wants_source = false;  // so that samples away from the surfaces are right, too; the surfaces are the same

  // The surfaces of all outputs, in the order of their iso values, as they would be written: placed, simplified,
  // verified. Those that EmptyPolicy::skip leaves out are not among them, and no old file is removed. Where there are
  // several iso values, each mesh is named after its own. The meshes keep what they have reserved.
  std::vector<mesh::Mesh> meshes = {};
  std::vector<SurfaceId> ids = {};    // one a mesh
  mesh_io::MeshPacking packing = {};  // how they are to be packed
  std::string placement = {};         // mesh_io::MeshWriteOptions has it
  std::optional<Source> source = {};  // of the surfaces, where it was asked for and the conversion did not fail
};

}  // namespace isoextract::convert
