#include "mesh_io/read/gltf_material.hpp"

#include <algorithm>
#include <array>

#include "mesh_io/read/gltf_json.hpp"

namespace isoextract::mesh_io {
namespace {

using nlohmann::json;

mesh::Material material_of(const json& material) {
  mesh::Material look;
  std::array<double, 4> factor{1, 1, 1, 1};
  const auto metal = material.find("pbrMetallicRoughness");
  if (metal != material.end() && metal->is_object()) {
    const auto color = metal->find("baseColorFactor");
    if (color != metal->end() && color->is_array() && color->size() == factor.size()) {
      for (std::size_t i = 0; i < factor.size(); ++i) {
        if ((*color)[i].is_number()) factor[i] = std::clamp((*color)[i].get<double>(), 0.0, 1.0);
      }
    }
  }
  look.color = glm::dvec3(factor[0], factor[1], factor[2]);
  // Other modes ignore alpha, or cut out parts of the surface by it.
  if (text_of(material, "alphaMode") == "BLEND" && factor[3] > 0) look.opacity = factor[3];
  const auto sides = material.find("doubleSided");
  look.double_sided = sides != material.end() && sides->is_boolean() && sides->get<bool>();
  return look;
}

}  // namespace

std::optional<mesh::Material> gltf_mesh_material(const json& model, const json& mesh) {
  const auto primitives = mesh.find("primitives");
  if (primitives == mesh.end() || !primitives->is_array()) return std::nullopt;
  std::optional<std::uint64_t> number;
  for (const json& primitive : *primitives) {
    if (!primitive.is_object() || !primitive.contains("material")) return std::nullopt;
    const std::uint64_t own = whole(primitive, "material");
    if (number && *number != own) return std::nullopt;
    number = own;
  }
  return number ? std::optional(material_of(entry(model, "materials", *number))) : std::nullopt;
}

}  // namespace isoextract::mesh_io
