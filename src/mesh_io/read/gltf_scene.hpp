// The scene of a glTF file: the meshes that its nodes show, their materials, and what isoextract does not read of it.
// Throws DamagedMesh for invalid values.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "mesh/mesh.hpp"
#include "mesh_io/read/gltf_json.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {

// A node that shows a mesh.
struct GltfInstance {
  std::uint64_t mesh = 0;
  Transform transform;
  std::uint64_t node = 0;
};

struct GltfScene {
  std::vector<GltfInstance> instances;  // depth first
  std::uint64_t hidden = 0;             // nodes with a mesh and a scale of 0, which are left out
};

// Returns the meshes of the default scene (the first scene if the file names none as default), or of all root nodes if
// the file has no scene.
[[nodiscard]] GltfScene find_gltf_scene(const nlohmann::json& model, MemoryUse& memory);

// Returns the color, opacity and sides of a primitive's material; nothing if it has no material. In a file of
// isoextract the color that its writer gives meshes without color counts as none.
[[nodiscard]] std::optional<mesh::Material> gltf_material(const nlohmann::json& model, const nlohmann::json& primitive,
                                                          bool is_by_isoextract);

// Returns the name of a primitive's material; empty if it has none.
[[nodiscard]] std::string_view gltf_material_name(const nlohmann::json& model, const nlohmann::json& primitive);

// Adds the kinds of data of a primitive and its material that a mesh::Mesh cannot hold: "textures", "skins".
void add_left_out(const nlohmann::json& model, const nlohmann::json& primitive, std::set<std::string>& kinds);
// Adds the kinds of data of the whole file that a mesh::Mesh cannot hold: "animations", "cameras".
void add_left_out(const nlohmann::json& model, std::set<std::string>& kinds);

}  // namespace isoextract::mesh_io
