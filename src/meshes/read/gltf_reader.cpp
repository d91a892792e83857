// glTF 2.0 (ISO/IEC 12113), .glb and .gltf: the triangles of the default scene, placed by its nodes in double. The JSON
// is read here and not by TinyGLTF, which trusts offsets of images and of animations that nobody asked for.
//
// Attributes are COLOR_0 and those that begin with an underscore, where all primitives have them in one form.
#include <algorithm>
#include <array>
#include <cstring>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "base/checked.hpp"
#include "meshes/detail/json_tree.hpp"
#include "meshes/read/gltf_json.hpp"
#include "meshes/read/mesh_format_readers.hpp"

namespace isoextract::meshes {
namespace {

using nlohmann::json;

constexpr int kByte = 5120;
constexpr int kUnsignedByte = 5121;
constexpr int kShort = 5122;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
// Modes of primitives; those below are points and lines.
constexpr std::uint64_t kTriangles = 4;
constexpr std::uint64_t kStrip = 5;
constexpr std::uint64_t kFan = 6;

std::optional<mesh::ComponentType> component_of(int code) {
  switch (code) {
    case kByte: return mesh::ComponentType::i8;
    case kUnsignedByte: return mesh::ComponentType::u8;
    case kShort: return mesh::ComponentType::i16;
    case kUnsignedShort: return mesh::ComponentType::u16;
    case kUnsignedInt: return mesh::ComponentType::u32;
    case kFloat: return mesh::ComponentType::f32;
    default: return std::nullopt;
  }
}

struct Instance {
  std::uint64_t mesh;
  Transform transform;
};

class ModelReader {
 public:
  ModelReader(const MeshSource& source, std::string_view text, std::span<const std::byte> binary)
      : source_(source), binary_(binary), tree_(parse_json(text, source.memory)) {
    if (!model_.is_object()) throw DamagedMesh("expected JSON in a glTF file, found something else");
  }

  FileSurface read() {
    const auto asset = model_.find("asset");
    const std::string_view version = asset != model_.end() && asset->is_object() ? text_of(*asset, "version") : "";
    if (!version.starts_with("2.")) {
      throw DamagedMesh(fmt::format("expected glTF of version 2, found '{}'", files::printable(version, 16)));
    }
    if (const auto required = model_.find("extensionsRequired"); required != model_.end() && !required->empty()) {
      throw DamagedMesh(fmt::format("expected glTF without required extensions, found {}", shown(*required)));
    }
    load_buffers();
    const std::vector<Instance> instances = find_instances();
    bool moved_alike = true;
    for (const Instance& instance : instances) {
      moved_alike = moved_alike && instance.transform.linear == glm::dmat3(1.0) &&
                    instance.transform.offset == instances.front().transform.offset;
    }
    if (moved_alike && !instances.empty()) surface_.origin = instances.front().transform.offset;
    for (const Instance& instance : instances) {
      Transform transform = instance.transform;
      if (surface_.origin) transform.offset = glm::dvec3(0);
      add_mesh(entry(model_, "meshes", instance.mesh), transform);
    }
    for (const std::string& name : left_out_) {
      surface_.notes.push_back(
          fmt::format("the attribute '{}' was left out: not all of its surfaces have it in one form", name));
    }
    if (corners_apart_ > 0) {
      surface_.notes.push_back(
          fmt::format("{} corners were joined with others at their place that have other attributes", corners_apart_));
    }
    if (other_primitives_ > 0) {
      surface_.notes.push_back(fmt::format("{} primitives of points or lines were left out", other_primitives_));
    }
    return std::move(surface_);
  }

 private:
  struct View {
    const std::byte* first = nullptr;
    std::uint64_t count = 0;
    std::uint64_t stride = 0;
    int component = 0;

    [[nodiscard]] glm::vec3 point(std::uint64_t index) const {
      glm::vec3 p;
      std::memcpy(&p, first + index * stride, sizeof p);
      return p;
    }
  };

  void load_buffers() {
    const auto list = model_.find("buffers");
    if (list == model_.end()) return;
    if (!list->is_array()) throw DamagedMesh("expected a list as 'buffers'");
    for (std::uint64_t i = 0; i < list->size(); ++i) load_buffer(entry(model_, "buffers", i), i);
  }

  void load_buffer(const json& buffer, std::uint64_t index) {
    const std::uint64_t size = whole(buffer, "byteLength");
    const std::string_view uri = text_of(buffer, "uri");
    std::span<const std::byte> bytes = binary_;
    if (!uri.empty()) {
      owned_.push_back(uri.starts_with("data:") ? decode_data_uri(uri, source_.memory)
                                                : load_file(decode_percent(uri)));
      bytes = owned_.back();
    } else if (index != 0) {
      throw DamagedMesh(fmt::format("expected a 'uri' of buffer {}, found none", index));
    }
    if (size > bytes.size()) {
      throw DamagedMesh(fmt::format("expected {} bytes of buffer {}, found {}", size, index, bytes.size()));
    }
    buffers_.push_back(bytes.first(size));
  }

  [[nodiscard]] std::vector<std::byte> load_file(const std::string& name) const {
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

  // Depth first; a node that is met twice would be in a cycle or have two parents, which glTF forbids.
  std::vector<Instance> find_instances() const {
    std::vector<Instance> instances;
    const auto scenes = model_.find("scenes");
    if (scenes == model_.end()) return instances;
    const json& scene = entry(model_, "scenes", whole(model_, "scene", 0));
    std::vector<std::pair<std::uint64_t, Transform>> waiting;
    const auto wait_for = [&](const json& object, const char* key, const Transform& parent) {
      const auto list = object.find(key);
      if (list == object.end()) return;
      if (!list->is_array()) throw DamagedMesh(fmt::format("expected a list as '{}', found {}", key, shown(*list)));
      source_.memory.make_room(waiting, list->size());
      for (auto node = list->rbegin(); node != list->rend(); ++node) {
        if (!node->is_number_unsigned()) {
          throw DamagedMesh(fmt::format("expected indices of nodes as '{}', found {}", key, shown(*list)));
        }
        waiting.emplace_back(node->get<std::uint64_t>(), parent);
      }
    };
    wait_for(scene, "nodes", {});
    const auto nodes = model_.find("nodes");
    std::vector<bool> met(nodes == model_.end() ? 0 : nodes->size());
    while (!waiting.empty()) {
      const auto [index, parent] = waiting.back();
      waiting.pop_back();
      const json& node = entry(model_, "nodes", index);
      if (met[index]) throw DamagedMesh(fmt::format("expected a tree of nodes, found node {} in two places", index));
      met[index] = true;
      const Transform transform = parent.after(transform_of(node));
      if (!transform.is_finite()) {
        throw DamagedMesh(fmt::format("expected a finite place of node {} within the scene, found ({}, {}, {})", index,
                                      transform.offset.x, transform.offset.y, transform.offset.z));
      }
      if (node.contains("mesh")) instances.push_back({whole(node, "mesh"), transform});
      wait_for(node, "children", transform);
    }
    return instances;
  }

  // An accessor whose bytes all lie within its view, and that within its buffer.
  [[nodiscard]] View view_of(std::uint64_t index, std::string_view type, std::uint64_t components) const {
    const json& accessor = entry(model_, "accessors", index);
    View view;
    view.component = static_cast<int>(whole(accessor, "componentType"));
    view.count = whole(accessor, "count");
    if (text_of(accessor, "type") != type) {
      throw DamagedMesh(fmt::format("expected an accessor of type {}, found {}", type, shown(accessor)));
    }
    if (accessor.contains("sparse") || !accessor.contains("bufferView")) {
      throw DamagedMesh(fmt::format("expected an accessor with all its values in a buffer, found {}", shown(accessor)));
    }
    const auto component = component_of(view.component);
    const std::uint64_t item = components * (component ? mesh::component_size(*component) : sizeof(float));
    const json& range = entry(model_, "bufferViews", whole(accessor, "bufferView"));
    const std::uint64_t buffer = whole(range, "buffer");
    if (buffer >= buffers_.size()) {
      throw DamagedMesh(
          fmt::format("expected fewer than {} as the index of a buffer, found {}", buffers_.size(), buffer));
    }
    view.stride = whole(range, "byteStride", item);
    const std::uint64_t range_start = whole(range, "byteOffset", 0);
    const std::uint64_t range_bytes = whole(range, "byteLength");
    const std::uint64_t start = whole(accessor, "byteOffset", 0);
    const auto range_end = checked_sum(range_start, range_bytes);
    const auto span = checked_product(view.count == 0 ? std::uint64_t{0} : view.count - 1, view.stride);
    const auto needed = span ? checked_sum(start, *span, view.count == 0 ? std::uint64_t{0} : item) : std::nullopt;
    if (!range_end || *range_end > buffers_[buffer].size() || !needed || *needed > range_bytes || view.stride < item) {
      throw DamagedMesh(
          fmt::format("expected {} values within a buffer of {} bytes, found the view {} and the accessor {}",
                      view.count, buffers_[buffer].size(), shown(range), shown(accessor)));
    }
    view.first = buffers_[buffer].data() + range_start + start;
    return view;
  }

  struct AttributeView {
    mesh::Attribute kind;  // without values
    View view;
  };

  [[nodiscard]] std::optional<AttributeView> attribute_of(const std::string& semantic, const json& index) {
    if (!index.is_number_unsigned()) {
      throw DamagedMesh(
          fmt::format("expected an accessor as '{}', found {}", files::printable(semantic, 40), shown(index)));
    }
    const json& accessor = entry(model_, "accessors", index.get<std::uint64_t>());
    constexpr std::array<std::string_view, mesh::kMaxComponents> kTypes{"SCALAR", "VEC2", "VEC3", "VEC4"};
    const std::string_view type = text_of(accessor, "type");
    const auto* found = std::find(kTypes.begin(), kTypes.end(), type);
    if (found == kTypes.end() || accessor.contains("sparse") || !accessor.contains("bufferView")) {
      surface_.notes.push_back(fmt::format("the attribute '{}' was left out: its values are {}",
                                           files::printable(semantic, 40), shown(accessor)));
      return std::nullopt;
    }
    AttributeView attribute;
    mesh::Attribute& kind = attribute.kind;
    kind.components = static_cast<std::size_t>(found - kTypes.begin()) + 1;
    attribute.view = view_of(index.get<std::uint64_t>(), type, kind.components);
    const auto component = component_of(attribute.view.component);
    if (!component) {
      throw DamagedMesh(fmt::format("expected a component type from {} to {} of '{}', found {}", kByte, kFloat,
                                    files::printable(semantic, 40), attribute.view.component));
    }
    kind.type = *component;
    const auto normalised = accessor.find("normalized");
    kind.normalised = normalised != accessor.end() && normalised->is_boolean() && normalised->get<bool>() &&
                      attribute.view.component != kFloat;
    if (semantic.starts_with('_')) {
      kind.name = semantic.substr(1);
      return attribute;
    }
    kind.name = "colour";
    kind.role = mesh::AttributeRole::colour;
    const bool fraction = kind.normalised && (kind.type == mesh::ComponentType::u8 ||  //
                                              kind.type == mesh::ComponentType::u16);
    if (kind.components < 3 || (!fraction && kind.type != mesh::ComponentType::f32)) {
      throw DamagedMesh(
          fmt::format("expected colours of three or four components, float or normalized unsigned ones, found {}",
                      shown(accessor)));
    }
    return attribute;
  }

  // Those of the primitive that go on from what is there, in the order of surface_.attributes. The first primitive says
  // what there may be; what is missing in a later one, or is of another form, goes.
  std::vector<View> attribute_views(const json& semantics, std::uint64_t vertices) {
    std::vector<AttributeView> found;
    for (const auto& [semantic, index] : semantics.items()) {
      if (semantic != "COLOR_0" && !semantic.starts_with('_')) continue;
      auto attribute = attribute_of(semantic, index);
      if (!attribute) continue;
      if (attribute->view.count != vertices) {
        throw DamagedMesh(fmt::format("expected {} values as '{}', one a vertex, found {}", vertices,
                                      files::printable(semantic, 40), attribute->view.count));
      }
      found.push_back(std::move(*attribute));
    }
    auto& there = surface_.attributes;
    if (std::exchange(is_first_primitive_, false)) {
      for (const AttributeView& attribute : found) there.push_back({attribute.kind.without_values(), {}});
    }
    const auto same = [](const mesh::Attribute& a, const mesh::Attribute& b) {
      return a.name == b.name && a.role == b.role && a.type == b.type && a.components == b.components &&
             a.normalised == b.normalised;
    };
    const auto leave_out = [&](const mesh::Attribute& kind) { left_out_.insert(files::printable(kind.name, 40)); };
    std::erase_if(there, [&](const FileAttribute& attribute) {
      const bool gone = std::none_of(found.begin(), found.end(),
                                     [&](const AttributeView& other) { return same(other.kind, attribute.kind); });
      if (gone) leave_out(attribute.kind);
      return gone;
    });
    std::vector<View> views;
    for (const FileAttribute& attribute : there) {
      views.push_back(std::find_if(found.begin(), found.end(), [&](const AttributeView& other) {
                        return same(other.kind, attribute.kind);
                      })->view);
    }
    for (const AttributeView& attribute : found) {
      const bool kept = std::any_of(there.begin(), there.end(),
                                    [&](const FileAttribute& other) { return same(other.kind, attribute.kind); });
      if (!kept) leave_out(attribute.kind);
    }
    return views;
  }

  // The values of the primitive's vertices for new vertices; new vertex i is vertex_at(i).
  template <class VertexAt>
  void add_values(const std::vector<View>& views, std::uint64_t count, const VertexAt& vertex_at) {
    for (std::size_t a = 0; a < views.size(); ++a) {
      auto& [kind, values] = surface_.attributes[a];
      source_.memory.make_room(values, count * kind.stride());
      for (std::uint64_t i = 0; i < count; ++i) {
        const std::byte* value = views[a].first + vertex_at(i) * views[a].stride;
        values.insert(values.end(), value, value + kind.stride());
      }
    }
  }

  // Makes vertices of the corners of a primitive without indices.
  void add_corners(const View& places, const std::vector<View>& views, std::uint64_t mode) {
    const std::uint64_t triangles = triangle_count(mode, places.count, "vertices");
    const std::size_t first_vertex = surface_.positions.size();
    const std::size_t first_triangle = surface_.triangles.size();
    std::vector<glm::vec3> corners;
    source_.memory.make_room(corners, 3 * triangles);
    for (std::uint64_t t = 0; t < triangles; ++t) {
      for (const std::uint64_t corner : corners_of(mode, t)) corners.push_back(places.point(corner));
    }
    require_vertex_count(first_vertex + corners.size());
    const std::vector<std::uint32_t> first_corner = weld_corners(corners, surface_, source_.memory);
    source_.memory.give_back(corners.capacity() * sizeof(glm::vec3));
    const auto vertex_at = [&](std::uint64_t corner) { return corners_of(mode, corner / 3)[corner % 3]; };
    add_values(views, first_corner.size(), [&](std::uint64_t v) { return vertex_at(first_corner[v]); });
    if (views.empty()) return;
    for (std::uint64_t c = 0; c < corners.size(); ++c) {
      const std::size_t v = surface_.triangles[first_triangle + c / 3][static_cast<int>(c % 3)];
      const std::uint64_t taken = vertex_at(first_corner[v - first_vertex]);
      bool apart = false;
      for (std::size_t a = 0; a < views.size(); ++a) {
        apart =
            apart || std::memcmp(views[a].first + vertex_at(c) * views[a].stride,
                                 views[a].first + taken * views[a].stride, surface_.attributes[a].kind.stride()) != 0;
      }
      corners_apart_ += apart ? 1 : 0;
    }
  }

  void add_mesh(const json& mesh, const Transform& transform) {
    const auto primitives = mesh.find("primitives");
    if (primitives == mesh.end() || !primitives->is_array()) {
      throw DamagedMesh(fmt::format("expected a list 'primitives' in a mesh, found {}", shown(mesh)));
    }
    for (const json& primitive : *primitives) {
      if (!primitive.is_object()) throw DamagedMesh(fmt::format("expected a primitive, found {}", shown(primitive)));
      const std::uint64_t mode = whole(primitive, "mode", kTriangles);
      if (mode > kFan) throw DamagedMesh(fmt::format("expected a 'mode' from 0 to {}, found {}", kFan, mode));
      if (mode < kTriangles) {
        ++other_primitives_;
      } else {
        add_primitive(primitive, mode, transform);
      }
    }
  }

  // How many triangles `corners` corners make.
  static std::uint64_t triangle_count(std::uint64_t mode, std::uint64_t corners, const char* what) {
    if (mode == kTriangles && corners % 3 != 0) {
      throw DamagedMesh(fmt::format("expected three {} a triangle, found {} in all", what, corners));
    }
    if (mode != kTriangles && corners < 3) {
      throw DamagedMesh(fmt::format("expected at least three {} of a strip or fan, found {}", what, corners));
    }
    return mode == kTriangles ? corners / 3 : corners - 2;
  }

  // Which of the primitive's corners are those of triangle t; glTF 2.0, 3.7.2.1.
  static std::array<std::uint64_t, 3> corners_of(std::uint64_t mode, std::uint64_t t) {
    if (mode == kStrip) return {t, t + 1 + t % 2, t + 2 - t % 2};
    if (mode == kFan) return {t + 1, t + 2, 0};
    return {3 * t, 3 * t + 1, 3 * t + 2};
  }

  void add_primitive(const json& primitive, std::uint64_t mode, const Transform& transform) {
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object()) {
      throw DamagedMesh(fmt::format("expected 'attributes' of a primitive, found {}", shown(primitive)));
    }
    const View places = view_of(whole(*attributes, "POSITION"), "VEC3", 3);
    if (places.component != kFloat) {
      throw DamagedMesh(fmt::format("expected positions of component type {}, found {}", kFloat, places.component));
    }
    const std::size_t first_vertex = surface_.positions.size();
    const std::size_t first_triangle = surface_.triangles.size();
    require_vertex_count(first_vertex + places.count);
    const std::vector<View> views = attribute_views(*attributes, places.count);
    if (primitive.contains("indices")) {
      source_.memory.make_room(surface_.positions, places.count);
      for (std::uint64_t v = 0; v < places.count; ++v) surface_.positions.emplace_back(places.point(v));
      add_values(views, places.count, [](std::uint64_t v) { return v; });
      add_indexed(view_of(whole(primitive, "indices"), "SCALAR", 1), mode, first_vertex, places.count);
    } else {
      add_corners(places, views, mode);
    }
    for (std::size_t v = first_vertex; v < surface_.positions.size(); ++v) {
      surface_.positions[v] = transform.linear * surface_.positions[v] + transform.offset;
    }
    // What a map that mirrors turned inside out is turned back; glTF 2.0, 3.7.4.
    if (glm::determinant(transform.linear) < 0) {
      for (std::size_t t = first_triangle; t < surface_.triangles.size(); ++t) {
        std::swap(surface_.triangles[t].y, surface_.triangles[t].z);
      }
    }
  }

  void add_indexed(const View& indices, std::uint64_t mode, std::size_t first_vertex, std::uint64_t vertices) {
    if (indices.component != kUnsignedByte && indices.component != kUnsignedShort &&
        indices.component != kUnsignedInt) {
      throw DamagedMesh(
          fmt::format("expected indices of an unsigned type, found component type {}", indices.component));
    }
    const std::uint64_t triangles = triangle_count(mode, indices.count, "indices");
    const auto index_at = [&](std::uint64_t i) {
      const std::size_t size = indices.component == kUnsignedByte ? 1 : indices.component == kUnsignedShort ? 2 : 4;
      std::uint32_t index = 0;
      std::memcpy(&index, indices.first + i * indices.stride, size);
      if (index >= vertices) {
        throw DamagedMesh(fmt::format("expected indices below {}, the number of vertices, found {}", vertices, index));
      }
      return static_cast<std::uint32_t>(first_vertex) + index;
    };
    source_.memory.make_room(surface_.triangles, triangles);
    for (std::uint64_t t = 0; t < triangles; ++t) {
      const auto [a, b, c] = corners_of(mode, t);
      surface_.triangles.emplace_back(index_at(a), index_at(b), index_at(c));
    }
  }

  const MeshSource& source_;
  std::span<const std::byte> binary_;  // of a .glb
  JsonTree tree_;
  const json& model_ = tree_.root();
  std::vector<std::vector<std::byte>> owned_;
  std::vector<std::span<const std::byte>> buffers_;
  std::uint64_t other_primitives_ = 0;
  bool is_first_primitive_ = true;
  std::set<std::string> left_out_;   // attributes
  std::uint64_t corners_apart_ = 0;  // that share a vertex with others, but not all attributes
  FileSurface surface_;
};

}  // namespace

FileSurface read_glb(const MeshSource& source) {
  constexpr std::size_t kHeaderBytes = 12;
  constexpr std::size_t kChunkHeaderBytes = 8;
  const auto word = [&](std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, source.content.data() + offset, sizeof value);
    return value;
  };
  const std::size_t size = source.content.size();
  if (size < kHeaderBytes + kChunkHeaderBytes || !source.text().starts_with("glTF")) {
    throw DamagedMesh(
        fmt::format("expected a binary glTF file, found '{}' in {} bytes", files::printable(source.text(), 16), size));
  }
  const std::uint64_t length = word(8);
  if (word(4) != 2) throw DamagedMesh(fmt::format("expected binary glTF of version 2, found {}", word(4)));
  if (length != size) throw DamagedMesh(fmt::format("expected {} bytes, as the header says, found {}", length, size));
  std::string_view text;
  std::span<const std::byte> binary;
  for (std::uint64_t at = kHeaderBytes; at < size;) {
    const std::uint64_t left = size - at;
    const std::uint64_t bytes = left < kChunkHeaderBytes ? left : word(at);
    if (left < kChunkHeaderBytes || bytes > left - kChunkHeaderBytes) {
      throw DamagedMesh(
          fmt::format("expected a chunk of {} bytes at byte {}, found {} bytes to the end", bytes, at, left));
    }
    const auto chunk = source.content.subspan(at + kChunkHeaderBytes, bytes);
    const std::string_view type = source.text().substr(at + 4, 4);
    if (type == "JSON" && text.empty()) text = source.text().substr(at + kChunkHeaderBytes, bytes);
    if (type == std::string_view("BIN\0", 4) && binary.empty()) binary = chunk;
    at += kChunkHeaderBytes + bytes;
  }
  FileSurface surface = ModelReader(source, text, binary).read();
  surface.format = "glTF, binary";
  return surface;
}

FileSurface read_gltf(const MeshSource& source) {
  FileSurface surface = ModelReader(source, source.text(), {}).read();
  surface.format = "glTF";
  return surface;
}

}  // namespace isoextract::meshes
