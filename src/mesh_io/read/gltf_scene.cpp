#include "mesh_io/read/gltf_scene.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

namespace isoextract::mesh_io {
namespace {

using nlohmann::json;

// Returns the object under `key`, or null.
const json* object_at(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_object() ? &*found : nullptr;
}

double number_at(const json& object, const char* key, double missing) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : missing;
}

// Returns the material of a primitive, or null.
const json* material_of(const json& model, const json& primitive) {
  return primitive.contains("material") ? &entry(model, "materials", whole(primitive, "material")) : nullptr;
}

// The base color of glTF: linear light and alpha.
std::array<double, 4> base_color(const json& material) {
  std::array<double, 4> color{1, 1, 1, 1};
  const json* const surface = object_at(material, "pbrMetallicRoughness");
  const auto factor = surface != nullptr ? surface->find("baseColorFactor") : material.end();
  if (surface == nullptr || factor == surface->end() || !factor->is_array() || factor->size() != color.size()) {
    return color;
  }
  for (std::size_t c = 0; c < color.size(); ++c) {
    if ((*factor)[c].is_number()) color[c] = std::clamp((*factor)[c].get<double>(), 0.0, 1.0);
  }
  return color;
}

bool has_texture(const json& material) {
  const json* const surface = object_at(material, "pbrMetallicRoughness");
  return material.contains("normalTexture") || material.contains("occlusionTexture") ||
         material.contains("emissiveTexture") ||
         (surface != nullptr &&
          (surface->contains("baseColorTexture") || surface->contains("metallicRoughnessTexture")));
}

// Returns whether the material's metalness, roughness, emission or extensions differ from the writer's.
bool has_own_light(const json& material) {
  constexpr double kMetallic = 0;
  constexpr double kRoughness = 0.6;
  const json* const surface = object_at(material, "pbrMetallicRoughness");
  const json none = json::object();
  const json& light = surface != nullptr ? *surface : none;
  return number_at(light, "metallicFactor", 1) != kMetallic || number_at(light, "roughnessFactor", 1) != kRoughness ||
         material.contains("emissiveFactor") || material.contains("extensions");
}

}  // namespace

// A node visited twice is in a cycle or has two parents, which glTF forbids.
GltfScene find_gltf_scene(const json& model, MemoryUse& memory) {
  GltfScene scene;
  std::vector<std::pair<std::uint64_t, Transform>> waiting;
  const auto wait_for = [&](const json& object, const char* key, const Transform& parent) {
    const auto list = object.find(key);
    if (list == object.end()) return;
    if (!list->is_array() ||
        !std::all_of(list->begin(), list->end(), [](const json& node) { return node.is_number_unsigned(); })) {
      throw DamagedMesh(fmt::format("'{}': expected a list of node indices, found {}", key, shown(*list)));
    }
    memory.make_room(waiting, list->size());
    for (auto node = list->rbegin(); node != list->rend(); ++node) {
      waiting.emplace_back(node->get<std::uint64_t>(), parent);
    }
  };
  const auto nodes = model.find("nodes");
  std::vector<bool> met(nodes == model.end() ? 0 : nodes->size());
  if (model.contains("scenes")) {
    wait_for(entry(model, "scenes", whole(model, "scene", 0)), "nodes", {});
  } else {  // no scene, as in a library of meshes: all root nodes
    for (std::uint64_t n = 0; n < met.size(); ++n) wait_for(entry(model, "nodes", n), "children", {});
    std::vector<bool> inner(met.size());
    for (const auto& [child, parent] : waiting) {
      if (child < inner.size()) inner[child] = true;
    }
    waiting.clear();
    for (std::uint64_t n = met.size(); n-- > 0;) {
      if (!inner[n]) waiting.emplace_back(n, Transform());
    }
  }
  while (!waiting.empty()) {
    const auto [index, parent] = waiting.back();
    waiting.pop_back();
    const json& node = entry(model, "nodes", index);
    if (met[index]) throw DamagedMesh(fmt::format("expected a tree of nodes, found node {} twice", index));
    met[index] = true;
    const Transform transform = parent.after(transform_of(node));
    if (!transform.is_finite()) {
      throw DamagedMesh(fmt::format("expected a finite position of node {} in the scene, found ({}, {}, {})", index,
                                    transform.offset.x, transform.offset.y, transform.offset.z));
    }
    if (node.contains("mesh") && transform.linear == glm::dmat3(0)) {
      ++scene.hidden;
    } else if (node.contains("mesh")) {
      scene.instances.push_back({whole(node, "mesh"), transform, index});
    }
    wait_for(node, "children", transform);
  }
  return scene;
}

std::optional<mesh::Material> gltf_material(const json& model, const json& primitive, bool is_by_isoextract) {
  const json* const given = material_of(model, primitive);
  if (given == nullptr) return std::nullopt;
  mesh::Material material;
  const std::array<double, 4> color = base_color(*given);
  constexpr double kLeastOpacity = 1e-3;  // a mesh::Material is not invisible
  if (text_of(*given, "alphaMode") == "BLEND") material.opacity = std::max(color[3], kLeastOpacity);
  const auto sides = given->find("doubleSided");
  material.double_sided = sides != given->end() && sides->is_boolean() && sides->get<bool>();
  const json* const attributes = object_at(primitive, "attributes");
  constexpr double kLightGray = 0.8;
  const double usual = attributes != nullptr && attributes->contains("COLOR_0") ? 1 : kLightGray;
  const glm::dvec3 rgb(color[0], color[1], color[2]);
  if (!is_by_isoextract || rgb != glm::dvec3(usual)) material.color = rgb;
  if (material == mesh::Material()) return std::nullopt;
  return material;
}

std::string_view gltf_material_name(const json& model, const json& primitive) {
  const json* const material = material_of(model, primitive);
  return material != nullptr ? text_of(*material, "name") : std::string_view();
}

void add_left_out(const json& model, const json& primitive, std::set<std::string>& kinds) {
  constexpr std::array<std::pair<std::string_view, const char*>, 5> kSemantics{{{"NORMAL", "normals"},
                                                                                {"TANGENT", "tangents"},
                                                                                {"TEXCOORD_", "texture coordinates"},
                                                                                {"JOINTS_", "skins"},
                                                                                {"COLOR_1", "second vertex colors"}}};
  if (const json* const attributes = object_at(primitive, "attributes")) {
    for (const auto& [name, accessor] : attributes->items()) {
      for (const auto& [start, kind] : kSemantics) {
        if (name.starts_with(start)) kinds.insert(kind);
      }
    }
  }
  if (primitive.contains("targets")) kinds.insert("morph targets");
  const json* const material = material_of(model, primitive);
  if (material == nullptr) return;
  if (has_texture(*material)) kinds.insert("textures");
  if (has_own_light(*material)) kinds.insert("metalness, roughness and light of materials");
}

void add_left_out(const json& model, std::set<std::string>& kinds) {
  for (const char* list : {"animations", "cameras"}) {
    const auto found = model.find(list);
    if (found != model.end() && !found->empty()) kinds.insert(list);
  }
}

}  // namespace isoextract::mesh_io
