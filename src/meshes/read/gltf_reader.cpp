// glTF 2.0 (ISO/IEC 12113), .glb and .gltf: the triangles of the default scene, placed by its nodes in double. The JSON
// is read here and not by TinyGLTF, which trusts offsets of images and of animations that nobody asked for.
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/checked.hpp"
#include "meshes/read/mesh_format_readers.hpp"

namespace isoextract::meshes {
namespace {

using nlohmann::json;

constexpr int kUnsignedByte = 5121;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
// Modes of primitives; those below are points and lines.
constexpr std::uint64_t kTriangles = 4;
constexpr std::uint64_t kStrip = 5;
constexpr std::uint64_t kFan = 6;

constexpr int kMaxDepth = 64;
// What a value of the JSON may take, with its key, its node in a map and the room of a growing list.
constexpr std::uint64_t kJsonValueBytes = 128;

// Values within values are visited by recursion, so hostile ones must not be deep.
json parse_json(std::string_view text, MemoryUse& memory) {
  memory.take(text.size());
  const auto check = [&](int depth, json::parse_event_t event, const json&) {
    if (event == json::parse_event_t::object_end || event == json::parse_event_t::array_end) return true;
    if (depth > kMaxDepth) {
      throw DamagedMesh(
          fmt::format("expected JSON nested at most {} deep, found a value at depth {}", kMaxDepth, depth));
    }
    memory.take(kJsonValueBytes);
    return true;
  };
  return json::parse(text, check, false);
}

std::string shown(const json& value) {
  return files::printable(value.dump(-1, ' ', true, json::error_handler_t::replace), 60);
}

// A whole number of an object, or `missing` where it has none.
std::uint64_t whole(const json& object, const char* key, std::optional<std::uint64_t> missing = {}) {
  const auto found = object.find(key);
  if (found == object.end() && missing) return *missing;
  if (found == object.end()) throw DamagedMesh(fmt::format("expected '{}' in {}, found none", key, shown(object)));
  if (!found->is_number_unsigned()) {
    throw DamagedMesh(fmt::format("expected a whole number as '{}', found {}", key, shown(*found)));
  }
  return found->get<std::uint64_t>();
}

// Entry `index` of a list of the model.
const json& entry(const json& model, const char* list, std::uint64_t index) {
  const auto found = model.find(list);
  const std::size_t size = found != model.end() && found->is_array() ? found->size() : 0;
  if (index >= size) {
    throw DamagedMesh(fmt::format("expected fewer than {} as an index into '{}', found {}", size, list, index));
  }
  if (!(*found)[index].is_object()) throw DamagedMesh(fmt::format("expected an object in '{}' at {}", list, index));
  return (*found)[index];
}

template <std::size_t kCount>
std::array<double, kCount> numbers(const json& list, const char* key) {
  std::array<double, kCount> out{};
  const bool fits = list.is_array() && list.size() == kCount;
  for (std::size_t i = 0; fits && i < kCount; ++i) {
    if (!list[i].is_number()) throw DamagedMesh(fmt::format("expected numbers as '{}', found {}", key, shown(list)));
    out[i] = list[i].get<double>();
  }
  if (!fits) throw DamagedMesh(fmt::format("expected {} numbers as '{}', found {}", kCount, key, shown(list)));
  return out;
}

// Affine map of a node in double.
struct Transform {
  glm::dmat3 linear{1.0};
  glm::dvec3 offset{0.0};

  [[nodiscard]] Transform after(const Transform& inner) const {
    return {linear * inner.linear, linear * inner.offset + offset};
  }
  [[nodiscard]] bool is_finite() const {
    return isoextract::is_finite(linear[0]) && isoextract::is_finite(linear[1]) && isoextract::is_finite(linear[2]) &&
           isoextract::is_finite(offset);
  }
};

Transform transform_of(const json& node) {
  Transform transform;
  if (const auto matrix = node.find("matrix"); matrix != node.end()) {
    const auto m = numbers<16>(*matrix, "matrix");
    transform.linear = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
    transform.offset = {m[12], m[13], m[14]};
    return transform;
  }
  if (const auto rotation = node.find("rotation"); rotation != node.end()) {
    const auto [x, y, z, w] = numbers<4>(*rotation, "rotation");
    // The rotation of a unit quaternion; glTF 2.0, 3.6.4.1.
    transform.linear = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w),     2 * (x * z - y * w),
                        2 * (x * y - z * w),     1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
                        2 * (x * z + y * w),     2 * (y * z - x * w),     1 - 2 * (x * x + y * y)};
  }
  if (const auto scale = node.find("scale"); scale != node.end()) {
    const auto factors = numbers<3>(*scale, "scale");
    for (int axis = 0; axis < 3; ++axis) transform.linear[axis] *= factors[static_cast<std::size_t>(axis)];
  }
  if (const auto translation = node.find("translation"); translation != node.end()) {
    const auto [x, y, z] = numbers<3>(*translation, "translation");
    transform.offset = {x, y, z};
  }
  return transform;
}

struct Instance {
  std::uint64_t mesh;
  Transform transform;
};

class ModelReader {
 public:
  ModelReader(const MeshSource& source, std::string_view text, std::span<const std::byte> binary)
      : source_(source), binary_(binary), model_(parse_json(text, source.memory)) {
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
  };

  static std::string_view text_of(const json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? std::string_view(found->get_ref<const std::string&>()) : "";
  }

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
    const auto file = files::InputFile::open(*path);
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
    const std::uint64_t item = components * (view.component == kUnsignedByte    ? 1
                                             : view.component == kUnsignedShort ? 2
                                                                                : 4);
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
    const auto point = [&](std::uint64_t v) {
      glm::vec3 p;
      std::memcpy(&p, places.first + v * places.stride, sizeof p);
      return p;
    };
    if (primitive.contains("indices")) {
      source_.memory.make_room(surface_.positions, places.count);
      for (std::uint64_t v = 0; v < places.count; ++v) surface_.positions.emplace_back(point(v));
      add_indexed(view_of(whole(primitive, "indices"), "SCALAR", 1), mode, first_vertex, places.count);
    } else {
      const std::uint64_t triangles = triangle_count(mode, places.count, "vertices");
      std::vector<glm::vec3> corners;
      source_.memory.make_room(corners, 3 * triangles);
      for (std::uint64_t t = 0; t < triangles; ++t) {
        for (const std::uint64_t corner : corners_of(mode, t)) corners.push_back(point(corner));
      }
      require_vertex_count(first_vertex + corners.size());
      weld_corners(corners, surface_, source_.memory);
      source_.memory.give_back(corners.capacity() * sizeof(glm::vec3));
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
  json model_;
  std::vector<std::vector<std::byte>> owned_;
  std::vector<std::span<const std::byte>> buffers_;
  std::uint64_t other_primitives_ = 0;
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
