#include "mesh_io/read/gltf_data.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include "base/checked.hpp"
#include "mesh_io/detail/meshopt_codec.hpp"
#include "mesh_io/read/gltf_json.hpp"

namespace isoextract::mesh_io {
namespace {

using nlohmann::json;

// Returns the bytes of a component; 4 for unknown types.
std::uint64_t size_of(int component) {
  const auto type = gltf_component(component);
  return type ? mesh::component_size(*type) : sizeof(float);
}

// Returns the object's member for the extension, or null.
const json* extension_of(const json& object, const char* name) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end() || !extensions->is_object()) return nullptr;
  const auto found = extensions->find(name);
  return found != extensions->end() && found->is_object() ? &*found : nullptr;
}

// Returns whether the buffer is a placeholder without bytes, named by views whose compressed bytes are elsewhere.
bool is_placeholder(const json& buffer) {
  const json* packed = extension_of(buffer, kMeshoptExtension);
  return packed != nullptr && packed->value("fallback", json(false)) == json(true);
}

const json& part_of(const json& sparse, const char* key) {
  const auto found = sparse.find(key);
  if (found == sparse.end() || !found->is_object()) {
    throw DamagedMesh(fmt::format("a sparse accessor needs an object '{}', found {}", key, shown(sparse)));
  }
  return *found;
}

}  // namespace

std::optional<mesh::ComponentType> gltf_component(int code) {
  switch (code) {
    case kGltfByte: return mesh::ComponentType::i8;
    case kGltfUnsignedByte: return mesh::ComponentType::u8;
    case kGltfShort: return mesh::ComponentType::i16;
    case kGltfUnsignedShort: return mesh::ComponentType::u16;
    case kGltfUnsignedInt: return mesh::ComponentType::u32;
    case kGltfFloat: return mesh::ComponentType::f32;
    default: return std::nullopt;
  }
}

glm::dvec3 GltfView::point(std::uint64_t index) const {
  const std::byte* place = first + index * stride;
  if (component == kGltfFloat) {
    glm::vec3 p;
    std::memcpy(&p, place, sizeof p);
    return p;
  }
  const auto type = gltf_component(component).value_or(mesh::ComponentType::u16);
  const std::uint64_t size = mesh::component_size(type);
  return {component_value(place, type, normalized), component_value(place + size, type, normalized),
          component_value(place + 2 * size, type, normalized)};
}

std::uint32_t GltfView::whole_number(std::uint64_t index) const {
  std::uint32_t number = 0;
  std::memcpy(&number, first + index * stride, size_of(component));
  return number;
}

GltfData::GltfData(const MeshSource& source, const json& model, std::span<const std::byte> binary)
    : source_(source), model_(model) {
  const auto list = model_.find("buffers");
  if (list == model_.end()) return;
  if (!list->is_array()) throw DamagedMesh("expected a list as 'buffers'");
  for (std::uint64_t i = 0; i < list->size(); ++i) load_buffer(entry(model_, "buffers", i), i, binary);
}

void GltfData::load_buffer(const json& buffer, std::uint64_t index, std::span<const std::byte> binary) {
  const std::uint64_t size = whole(buffer, "byteLength");
  const std::string_view uri = text_of(buffer, "uri");
  std::span<const std::byte> bytes = binary;
  if (!uri.empty()) {
    owned_.push_back(uri.starts_with("data:") ? decode_data_uri(uri, source_.memory) : load_file(decode_percent(uri)));
    bytes = owned_.back();
  } else if (is_placeholder(buffer)) {
    buffers_.emplace_back();
    return;
  } else if (index != 0) {
    throw DamagedMesh(fmt::format("expected a 'uri' of buffer {}, found none", index));
  }
  if (size > bytes.size()) {
    throw DamagedMesh(fmt::format("expected {} bytes of buffer {}, found {}", size, index, bytes.size()));
  }
  buffers_.push_back(bytes.first(size));
}

std::vector<std::byte> GltfData::load_file(const std::string& name) const {
  const auto path = files::resolve_beside(source_.file.path(), name);
  if (!path) throw DamagedMesh(path.error().message, path.error().hint);
  const auto file = files::InputFile::open(*path, source_.file.context());
  if (!file) throw DamagedMesh(file.error().message);
  std::vector<std::byte> bytes;
  source_.memory.make_room(bytes, file->size());
  bytes.resize(file->size());
  if (auto read = file->read_at(0, bytes); !read) throw DamagedMesh(read.error().message);
  return bytes;
}

GltfView GltfData::view(std::uint64_t index, std::string_view type, std::uint64_t components) {
  const json& accessor = entry(model_, "accessors", index);
  if (text_of(accessor, "type") != type) {
    throw DamagedMesh(fmt::format("expected an accessor of type {}, found {}", type, shown(accessor)));
  }
  if (const auto made = made_views_.find(index); made != made_views_.end()) return made->second;
  GltfView view;
  view.component = static_cast<int>(whole(accessor, "componentType"));
  view.count = whole(accessor, "count");
  const auto normalized = accessor.find("normalized");
  view.normalized = normalized != accessor.end() && normalized->is_boolean() && normalized->get<bool>() &&
                    view.component != kGltfFloat;
  const std::uint64_t item = components * size_of(view.component);
  const auto sparse = accessor.find("sparse");
  if (accessor.contains("bufferView")) {
    place(view, accessor, item);
  } else if (sparse == accessor.end()) {
    // glTF defines such an accessor as all zeros, but data compressed by an unknown extension looks the same.
    throw DamagedMesh(fmt::format("expected an accessor with values in a buffer, found {}", shown(accessor)));
  }
  if (sparse == accessor.end()) return view;
  return made_views_.emplace(index, with_sparse(view, *sparse, item)).first->second;
}

std::span<const std::byte> GltfData::range_of(const json& range) const {
  const std::uint64_t buffer = whole(range, "buffer");
  if (buffer >= buffers_.size()) {
    throw DamagedMesh(
        fmt::format("expected fewer than {} as the index of a buffer, found {}", buffers_.size(), buffer));
  }
  const std::uint64_t start = whole(range, "byteOffset", 0);
  const std::uint64_t bytes = whole(range, "byteLength");
  const auto end = checked_sum(start, bytes);
  if (!end || *end > buffers_[buffer].size()) {
    throw DamagedMesh(
        fmt::format("expected a view within a buffer of {} bytes, found {}", buffers_[buffer].size(), shown(range)));
  }
  return buffers_[buffer].subspan(start, bytes);
}

std::span<const std::byte> GltfData::unpacked_view(std::uint64_t index, const json& packed) {
  if (const auto found = unpacked_views_.find(index); found != unpacked_views_.end()) return found->second;
  constexpr std::array kModes{MeshoptMode::attributes, MeshoptMode::triangles, MeshoptMode::indices};
  constexpr std::array<std::string_view, 4> kFilters{"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
  const auto mode = std::ranges::find(kModes, text_of(packed, "mode"), meshopt_word);
  const auto filter =
      packed.contains("filter") ? std::ranges::find(kFilters, text_of(packed, "filter")) : kFilters.begin();
  MeshoptView view;
  view.count = whole(packed, "count");
  view.stride = whole(packed, "byteStride");
  if (mode != kModes.end()) view.mode = *mode;
  view.filter = static_cast<MeshoptFilter>(filter - kFilters.begin());
  const auto bytes = checked_product(view.count, view.stride);
  if (mode == kModes.end() || filter == kFilters.end() || !is_valid(view) || !bytes) {
    throw DamagedMesh(fmt::format("expected a mode, filter, byteStride and count that {} allows, found {}",
                                  kMeshoptExtension, shown(packed)));
  }
  std::vector<std::byte>& unpacked = owned_.emplace_back();
  source_.memory.make_room(unpacked, *bytes);
  unpacked.resize(*bytes);
  if (!decode_meshopt(range_of(packed), view, unpacked)) {
    throw DamagedMesh(fmt::format("expected packed values in a buffer view, found damaged data: {}", shown(packed)));
  }
  return unpacked_views_.emplace(index, unpacked).first->second;
}

void GltfData::place(GltfView& view, const json& owner, std::uint64_t item) {
  const std::uint64_t index = whole(owner, "bufferView");
  const json& range = entry(model_, "bufferViews", index);
  const json* packed = extension_of(range, kMeshoptExtension);
  const std::span<const std::byte> values = packed != nullptr ? unpacked_view(index, *packed) : range_of(range);
  view.stride = packed != nullptr ? whole(*packed, "byteStride") : whole(range, "byteStride", item);
  const std::uint64_t start = whole(owner, "byteOffset", 0);
  const auto span = checked_product(view.count == 0 ? std::uint64_t{0} : view.count - 1, view.stride);
  const auto needed = span ? checked_sum(start, *span, view.count == 0 ? std::uint64_t{0} : item) : std::nullopt;
  if (!needed || *needed > values.size() || view.stride < item) {
    throw DamagedMesh(
        fmt::format("expected a buffer view with room for {} values, found {} bytes (accessor {}, view {})", view.count,
                    values.size(), shown(owner), shown(range)));
  }
  view.first = values.data() + start;
}

// Builds a sparse accessor (glTF 2.0, 3.6.2.3): replaces the values at the given ascending indices. The base values
// come from the buffer view, or are zeros without one.
GltfView GltfData::with_sparse(const GltfView& dense, const json& sparse, std::uint64_t item) {
  if (!sparse.is_object()) {
    throw DamagedMesh(fmt::format("expected a JSON object as 'sparse' of an accessor, found {}", shown(sparse)));
  }
  GltfView values;
  values.count = whole(sparse, "count");
  GltfView indices = values;
  const json& index_part = part_of(sparse, "indices");
  indices.component = static_cast<int>(whole(index_part, "componentType"));
  if (!indices.has_whole_numbers()) {
    throw DamagedMesh(
        fmt::format("expected indices of component type 5121, 5123 or 5125, found {}", indices.component));
  }
  place(indices, index_part, size_of(indices.component));
  place(values, part_of(sparse, "values"), item);

  const auto bytes = checked_product(dense.count, item);
  if (!bytes) {
    throw DamagedMesh(fmt::format("expected an accessor whose size fits into memory, found {} values", dense.count));
  }
  std::vector<std::byte>& whole_values = owned_.emplace_back();
  source_.memory.make_room(whole_values, *bytes);
  whole_values.resize(*bytes);
  for (std::uint64_t i = 0; dense.first != nullptr && i < dense.count; ++i) {
    std::memcpy(whole_values.data() + i * item, dense.first + i * dense.stride, item);
  }
  std::uint64_t least = 0;
  for (std::uint64_t i = 0; i < values.count; ++i) {
    const std::uint64_t index = indices.whole_number(i);
    if (index < least || index >= dense.count) {
      throw DamagedMesh(fmt::format("expected increasing indices of sparse values below {}, found {} at position {}",
                                    dense.count, index, i));
    }
    std::memcpy(whole_values.data() + index * item, values.first + i * values.stride, item);
    least = index + 1;
  }
  GltfView view = dense;
  view.first = whole_values.data();
  view.stride = item;
  return view;
}

}  // namespace isoextract::mesh_io
