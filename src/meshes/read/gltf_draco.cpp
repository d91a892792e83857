// KHR_draco_mesh_compression: the accessors of a primitive have their values from Draco's bytes.
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "meshes/read/draco_vertices.hpp"
#include "meshes/read/gltf_data.hpp"
#include "meshes/read/gltf_json.hpp"

namespace isoextract::meshes {
namespace {

using nlohmann::json;

const json* draco_of(const json& primitive) {
  const auto extensions = primitive.find("extensions");
  if (extensions == primitive.end() || !extensions->is_object()) return nullptr;
  const auto draco = extensions->find(kDracoExtension);
  return draco != extensions->end() && draco->is_object() ? &*draco : nullptr;
}

void require_count(const json& accessor, std::uint64_t count) {
  if (whole(accessor, "count") == count) return;
  throw DamagedMesh(fmt::format("expected {} values, as Draco unpacks them, found {}", count, shown(accessor)));
}

}  // namespace

bool GltfData::unpack_draco(const json& primitive) {
  const json* draco = draco_of(primitive);
  if (draco == nullptr) return false;
  const json& semantics = primitive.at("attributes");
  // Whoever has both need not unpack.
  if (entry(model_, "accessors", whole(semantics, "POSITION")).contains("bufferView")) return false;
  const std::uint64_t packed = whole(*draco, "bufferView");
  if (const auto made = unpacked_draco_.find(packed); made != unpacked_draco_.end()) return made->second;
  const auto ids = draco->find("attributes");
  if (ids == draco->end() || !ids->is_object()) {
    throw DamagedMesh(fmt::format("expected 'attributes' of packed triangles, found {}", shown(*draco)));
  }
  DracoSurface surface = unpack_draco_surface(range_of(entry(model_, "bufferViews", packed)), source_.memory);
  const bool is_soup = order_as_corners(surface, source_.memory);
  unpacked_draco_.emplace(packed, is_soup);
  for (const auto& [semantic, id] : ids->items()) {
    DracoAttribute* attribute = id.is_number_unsigned() ? surface.find(id.get<std::uint64_t>()) : nullptr;
    if (attribute == nullptr) {
      throw DamagedMesh(fmt::format("expected packed attributes that are there, found '{}' as {}",
                                    files::printable(semantic, 40), shown(id)));
    }
    provide(whole(semantics, semantic.c_str()), *attribute, surface.vertices);
  }
  if (is_soup || !primitive.contains("indices")) return is_soup;
  const std::uint64_t accessor = whole(primitive, "indices");
  GltfView view;
  view.count = 3 * surface.triangles.size();
  view.stride = sizeof(std::uint32_t);
  view.component = kGltfUnsignedInt;
  require_count(entry(model_, "accessors", accessor), view.count);
  std::vector<std::byte>& values = owned_.emplace_back();
  source_.memory.make_room(values, view.count * view.stride);
  values.resize(view.count * view.stride);
  if (!values.empty()) std::memcpy(values.data(), surface.triangles.data(), values.size());
  view.first = values.data();
  made_views_.insert_or_assign(accessor, view);
  return false;
}

void GltfData::provide(std::uint64_t accessor, DracoAttribute& attribute, std::uint64_t vertices) {
  const json& description = entry(model_, "accessors", accessor);
  require_count(description, vertices);
  const std::uint64_t code = whole(description, "componentType");
  const std::string type =
      attribute.components == 1 ? std::string("SCALAR") : fmt::format("VEC{}", attribute.components);
  if (code > kGltfFloat || gltf_component(static_cast<int>(code)) != attribute.type ||
      text_of(description, "type") != type) {
    throw DamagedMesh(fmt::format("expected values of {} and type {}, as Draco unpacks them, found {}",
                                  mesh::component_name(attribute.type), type, shown(description)));
  }
  const auto normalised = description.find("normalized");
  GltfView view;
  view.count = vertices;
  view.stride = attribute.components * mesh::component_size(attribute.type);
  view.component = static_cast<int>(code);
  view.normalised = normalised != description.end() && normalised->is_boolean() && normalised->get<bool>() &&
                    view.component != kGltfFloat;
  view.first = owned_.emplace_back(std::move(attribute.values)).data();
  made_views_.insert_or_assign(accessor, view);
}

}  // namespace isoextract::meshes
