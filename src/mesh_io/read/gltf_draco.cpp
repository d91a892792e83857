// KHR_draco_mesh_compression: Draco's bytes supply the values of a primitive's accessors.
#include <span>
#include <utility>

#include <fmt/format.h>

#include "mesh_io/read/draco_vertices.hpp"
#include "mesh_io/read/gltf_data.hpp"
#include "mesh_io/read/gltf_json.hpp"

namespace isoextract::mesh_io {
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
  throw DamagedMesh(fmt::format("expected an accessor with a count of {}, as in the Draco bit stream; found {}", count,
                                shown(accessor)));
}

}  // namespace

bool GltfData::unpack_draco(const json& primitive) {
  const json* draco = draco_of(primitive);
  if (draco == nullptr) return false;
  const json& semantics = primitive.at("attributes");
  // The file also has uncompressed values, so nothing needs decoding.
  if (entry(model_, "accessors", whole(semantics, "POSITION")).contains("bufferView")) return false;
  const auto ids = draco->find("attributes");
  if (ids == draco->end() || !ids->is_object()) {
    throw DamagedMesh(fmt::format("expected 'attributes' of packed triangles, found {}", shown(*draco)));
  }
  const UnpackedDraco& unpacked = unpacked_draco(whole(*draco, "bufferView"));
  const DracoSurface& surface = unpacked.surface;
  for (const auto& [semantic, id] : ids->items()) {
    const DracoAttribute* attribute = id.is_number_unsigned() ? surface.find(id.get<std::uint64_t>()) : nullptr;
    if (attribute == nullptr) {
      throw DamagedMesh(fmt::format("the Draco data have no attribute with the id {}, which the file gives for '{}'",
                                    shown(id), files::printable(semantic, 40)));
    }
    provide(whole(semantics, semantic.c_str()), *attribute, surface.vertices);
  }
  if (unpacked.is_soup || !primitive.contains("indices")) return unpacked.is_soup;
  const std::uint64_t accessor = whole(primitive, "indices");
  const json& description = entry(model_, "accessors", accessor);
  GltfView view;
  view.count = 3 * surface.triangles.size();
  view.stride = sizeof(std::uint32_t);
  view.component = kGltfUnsignedInt;
  require_count(description, view.count);
  if (text_of(description, "type") != "SCALAR") {
    throw DamagedMesh(fmt::format("expected indices of type SCALAR, found {}", shown(description)));
  }
  view.first = std::as_bytes(std::span(surface.triangles)).data();
  made_views_.insert_or_assign(accessor, view);
  return false;
}

const GltfData::UnpackedDraco& GltfData::unpacked_draco(std::uint64_t view) {
  if (const auto found = unpacked_draco_.find(view); found != unpacked_draco_.end()) return found->second;
  UnpackedDraco unpacked{unpack_draco_surface(range_of(entry(model_, "bufferViews", view)), source_.memory)};
  unpacked.is_soup = order_as_corners(unpacked.surface, source_.memory);
  return unpacked_draco_.emplace(view, std::move(unpacked)).first->second;
}

void GltfData::provide(std::uint64_t accessor, const DracoAttribute& attribute, std::uint64_t vertices) {
  const json& description = entry(model_, "accessors", accessor);
  require_count(description, vertices);
  const std::uint64_t code = whole(description, "componentType");
  const std::string type =
      attribute.components == 1 ? std::string("SCALAR") : fmt::format("VEC{}", attribute.components);
  if (code > kGltfFloat || gltf_component(static_cast<int>(code)) != attribute.type ||
      text_of(description, "type") != type) {
    throw DamagedMesh(
        fmt::format("expected an accessor with component type {} and type {}, as in the Draco bit stream; found {}",
                    mesh::component_name(attribute.type), type, shown(description)));
  }
  const auto normalized = description.find("normalized");
  GltfView view;
  view.count = vertices;
  view.stride = attribute.components * mesh::component_size(attribute.type);
  view.component = static_cast<int>(code);
  view.normalized = normalized != description.end() && normalized->is_boolean() && normalized->get<bool>() &&
                    view.component != kGltfFloat;
  view.first = attribute.values.data();
  made_views_.insert_or_assign(accessor, view);
}

}  // namespace isoextract::mesh_io
