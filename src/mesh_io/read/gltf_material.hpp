// The materials of glTF meshes. Throws DamagedMesh for invalid values.
#pragma once

#include <optional>

#include <nlohmann/json.hpp>

#include "mesh/mesh.hpp"

namespace isoextract::mesh_io {

// Returns the material that all triangles of a glTF mesh have: color, opacity and sides. Returns nothing if they have
// none, or several.
[[nodiscard]] std::optional<mesh::Material> gltf_mesh_material(const nlohmann::json& model, const nlohmann::json& mesh);

}  // namespace isoextract::mesh_io
