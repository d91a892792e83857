// Meshes of glTF files, which are y up, in a world that is z up.
#pragma once

#include "mesh/mesh.hpp"

namespace isoextract::cli {

// The way back from what a conversion does for glTF (convert::output_from_index). Nothing is rounded. The mesh has no
// normals yet.
void turn_y_up_to_z_up(mesh::Mesh& mesh);

}  // namespace isoextract::cli
