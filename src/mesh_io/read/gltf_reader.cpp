// Reads glTF 2.0 (ISO/IEC 12113), .glb and .gltf: the triangles of the default scene, transformed by its nodes in
// double. Does not use TinyGLTF, which trusts the offsets of images and animations that are not needed here.
//
// Skips nodes that are scaled to zero. Reads the first frame of an animated sequence (write/animated_glb.hpp).
//
// Reads COLOR_0 and attributes that begin with an underscore, if all primitives have them with the same type.
#include <algorithm>
#include <array>
#include <cstring>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "mesh_io/detail/json_tree.hpp"
#include "mesh_io/detail/placement_entry.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "mesh_io/read/gltf_data.hpp"
#include "mesh_io/read/gltf_json.hpp"
#include "mesh_io/read/gltf_normals.hpp"
#include "mesh_io/read/gltf_scene.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {
namespace {

using nlohmann::json;

// Modes of primitives; smaller numbers are points and lines.
constexpr std::uint64_t kTriangles = 4;
constexpr std::uint64_t kStrip = 5;
constexpr std::uint64_t kFan = 6;

constexpr std::uint64_t kNoMaterial = ~std::uint64_t{0};

// Prefixes of extensions that do not change triangles: shading, lights, textures, sound, animation and metadata.
constexpr std::array<std::string_view, 16> kOtherExtensions{"KHR_materials_",
                                                            "EXT_materials_",
                                                            "ADOBE_materials_",
                                                            "KHR_texture_",
                                                            "EXT_texture_",
                                                            "MSFT_texture_",
                                                            "KHR_lights_",
                                                            "EXT_lights_",
                                                            "KHR_animation_",
                                                            "KHR_audio",
                                                            "KHR_xmp",
                                                            "EXT_mesh_features",
                                                            "EXT_structural_metadata",
                                                            "EXT_feature_metadata",
                                                            "AGI_",
                                                            "FB_ngon_encoding"};
// Supported extensions that change how triangles are stored.
constexpr std::array<std::string_view, 3> kPackingExtensions{kDracoExtension, kQuantizationExtension,
                                                             kMeshoptExtension};

bool changes_triangles(std::string_view extension) {
  return std::ranges::find(kPackingExtensions, extension) == kPackingExtensions.end() &&
         std::none_of(kOtherExtensions.begin(), kOtherExtensions.end(),
                      [&](std::string_view start) { return extension.starts_with(start); });
}

std::string placement_of(const json& asset) {
  const auto extras = asset.find("extras");
  if (extras == asset.end() || !extras->is_object()) return {};
  const auto placement = extras->find(kPlacementEntry);
  return placement == extras->end() ? std::string() : placement->dump(-1, ' ', true, json::error_handler_t::replace);
}

class ModelReader {
 public:
  ModelReader(const MeshSource& source, std::string_view text, std::span<const std::byte> binary)
      : source_(source), binary_(binary), tree_(parse_json(text, source.memory)) {
    if (!model_.is_object()) throw DamagedMesh("expected a JSON object in a glTF file, found something else");
    surface_.y_up = true;
  }

  FileSurface read() {
    const auto asset = model_.find("asset");
    const std::string_view version = asset != model_.end() && asset->is_object() ? text_of(*asset, "version") : "";
    if (!version.starts_with("2.")) {
      throw DamagedMesh(fmt::format("expected glTF of version 2, found '{}'", files::printable(version, 16)));
    }
    surface_.is_by_isoextract = is_signature(text_of(*asset, "generator"));
    surface_.placement = placement_of(*asset);
    check_extensions();
    data_.emplace(source_, model_, binary_);
    const auto [instances, hidden] = find_gltf_scene(model_, source_.memory);
    bool moved_alike = true;
    for (const GltfInstance& instance : instances) {
      moved_alike = moved_alike && instance.transform.linear == glm::dmat3(1.0) &&
                    instance.transform.offset == instances.front().transform.offset;
    }
    if (moved_alike && !instances.empty()) surface_.origin = instances.front().transform.offset;
    for (const GltfInstance& instance : instances) {
      Transform transform = instance.transform;
      if (surface_.origin) transform.offset = glm::dvec3(0);
      const json& mesh = entry(model_, "meshes", instance.mesh);
      std::string_view name = text_of(mesh, "name");
      if (const std::string_view of_node = text_of(entry(model_, "nodes", instance.node), "name");
          source_.as_scene && !of_node.empty()) {
        name = of_node;
      }
      add_mesh(mesh, name, transform);
    }
    if (source_.as_scene) add_left_out(model_, surface_.left_out);
    for (const std::string& name : left_out_) {
      note(NoteId::attribute_left_out,
           "skips the attribute '{}': its type differs between the surfaces, or some lack it", name);
    }
    if (corners_apart_ > 0) {
      note(NoteId::corners_joined, "merges {} corners with corners at the same position that have other attributes",
           corners_apart_);
    }
    if (hidden > 0) {
      note(NoteId::data_left_out, "skips {} surfaces with a scale of 0{}", hidden,
           model_.contains("animations") ? ", which the animation shows later: the reader uses the pose at rest" : "");
    }
    if (other_primitives_ > 0) note(NoteId::data_left_out, "skips {} primitives of points or lines", other_primitives_);
    return std::move(surface_);
  }

 private:
  // Adds a note that begins with "the reader".
  template <class... Values>
  void note(NoteId id, fmt::format_string<Values...> text, Values&&... values) {
    surface_.notes.push_back({id, "the reader " + fmt::format(text, std::forward<Values>(values)...)});
  }

  void check_extensions() {
    const auto required = model_.find("extensionsRequired");
    if (required == model_.end()) return;
    if (!required->is_array()) {
      throw DamagedMesh(fmt::format("expected a list as 'extensionsRequired', found {}", shown(*required)));
    }
    for (const json& extension : *required) {
      const std::string_view name =
          extension.is_string() ? std::string_view(extension.get_ref<const std::string&>()) : "";
      has_quantized_ = has_quantized_ || name == kQuantizationExtension;
      if (!name.empty() && !changes_triangles(name)) continue;
      throw DamagedMesh(fmt::format("expected Draco, meshopt or quantization as the only extensions for triangles, "
                                    "found the required extension {}",
                                    shown(extension)),
                        "export the file without this extension");
    }
  }

  struct AttributeView {
    mesh::Attribute kind;  // without values
    GltfView view;
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
    const bool has_values = accessor.contains("bufferView") || accessor.contains("sparse") ||
                            data_->is_unpacked(index.get<std::uint64_t>());
    if (found == kTypes.end() || !has_values) {
      note(NoteId::attribute_left_out, "skips the attribute '{}': {}", files::printable(semantic, 40),
           has_values ? "its values are neither numbers nor vectors" : "it has no values");
      return std::nullopt;
    }
    AttributeView attribute;
    mesh::Attribute& kind = attribute.kind;
    kind.components = static_cast<std::size_t>(found - kTypes.begin()) + 1;
    attribute.view = data_->view(index.get<std::uint64_t>(), type, kind.components);
    const auto component = gltf_component(attribute.view.component);
    if (!component) {
      throw DamagedMesh(fmt::format("expected component type 5120, 5121, 5122, 5123, 5125 or 5126 of '{}', found {}",
                                    files::printable(semantic, 40), attribute.view.component));
    }
    kind.type = *component;
    kind.normalized = attribute.view.normalized;
    if (semantic.starts_with('_')) {
      kind.name = semantic.substr(1);
      return attribute;
    }
    kind.name = "color";
    kind.role = mesh::AttributeRole::color;
    const bool fraction = kind.normalized && (kind.type == mesh::ComponentType::u8 ||  //
                                              kind.type == mesh::ComponentType::u16);
    if (kind.components < 3 || (!fraction && kind.type != mesh::ComponentType::f32)) {
      throw DamagedMesh(fmt::format(
          "expected colors with three or four components, float or normalized unsigned, found {}", shown(accessor)));
    }
    return attribute;
  }

  // Returns the primitive's views for the attributes in surface_.attributes, in that order. The first primitive sets
  // these attributes. An attribute that a later primitive lacks, or has with another type, is dropped.
  std::vector<GltfView> attribute_views(const json& semantics, std::uint64_t vertices) {
    std::vector<AttributeView> found;
    for (const auto& [semantic, index] : semantics.items()) {
      if (semantic != "COLOR_0" && !semantic.starts_with('_')) continue;
      auto attribute = attribute_of(semantic, index);
      if (!attribute) continue;
      if (attribute->view.count != vertices) {
        throw DamagedMesh(fmt::format("expected {} values of '{}', one per vertex, found {}", vertices,
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
             a.normalized == b.normalized;
    };
    const auto leave_out = [&](const mesh::Attribute& kind) { left_out_.insert(files::printable(kind.name, 40)); };
    std::erase_if(there, [&](const FileAttribute& attribute) {
      const bool gone = std::none_of(found.begin(), found.end(),
                                     [&](const AttributeView& other) { return same(other.kind, attribute.kind); });
      if (gone) leave_out(attribute.kind);
      return gone;
    });
    std::vector<GltfView> views;
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

  // Appends attribute values for `count` new vertices; new vertex i copies the primitive's vertex vertex_at(i).
  template <class VertexAt>
  void add_values(const std::vector<GltfView>& views, std::uint64_t count, const VertexAt& vertex_at) {
    for (std::size_t a = 0; a < views.size(); ++a) {
      auto& [kind, values] = surface_.attributes[a];
      source_.memory.make_room(values, count * kind.stride());
      for (std::uint64_t i = 0; i < count; ++i) {
        const std::byte* value = views[a].first + vertex_at(i) * views[a].stride;
        values.insert(values.end(), value, value + kind.stride());
      }
    }
  }

  // Welds the corners of a primitive without indices into vertices.
  void add_corners(const GltfView& places, const std::vector<GltfView>& views, std::uint64_t mode) {
    const std::uint64_t triangles = triangle_count(mode, places.count, "vertices");
    const std::size_t first_vertex = surface_.positions.size();
    const std::size_t first_triangle = surface_.triangles.size();
    std::vector<glm::vec3> corners;
    source_.memory.make_room(corners, 3 * triangles);
    for (std::uint64_t t = 0; t < triangles; ++t) {
      for (const std::uint64_t corner : corners_of(mode, t)) corners.emplace_back(places.point(corner));
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

  // Begins a part of the file at the next vertex.
  void add_part(std::string_view name, const std::optional<mesh::Material>& material) {
    constexpr std::size_t kNameBytes = 200;  // bounds memory: many nodes may show the same mesh
    name = name.substr(0, kNameBytes);
    source_.memory.make_room(surface_.parts, 1);
    source_.memory.take(2 * (sizeof(MeshPart) + name.size()));  // twice: also in MeshFile::parts
    surface_.parts.push_back({std::string(name), surface_.positions.size(), surface_.triangles.size(), material});
  }

  // Adds the primitives of a mesh as one part; for a scene, as one part per run of primitives with equal material.
  void add_mesh(const json& mesh, std::string_view name, const Transform& transform) {
    const auto primitives = mesh.find("primitives");
    if (primitives == mesh.end() || !primitives->is_array()) {
      throw DamagedMesh(fmt::format("expected a list 'primitives' in a mesh, found {}", shown(mesh)));
    }
    if (!source_.as_scene || primitives->empty()) add_part(name, {});
    const json* before = nullptr;  // the last primitive that was added
    const auto material_of = [](const json& primitive) { return whole(primitive, "material", kNoMaterial); };
    bool several = false;
    for (const json& primitive : *primitives) {
      if (!primitive.is_object())
        throw DamagedMesh(fmt::format("expected JSON objects as primitives, found {}", shown(primitive)));
      several = several || material_of(primitive) != material_of(primitives->front());
    }
    for (const json& primitive : *primitives) {
      const std::uint64_t mode = whole(primitive, "mode", kTriangles);
      if (mode > kFan) throw DamagedMesh(fmt::format("expected a 'mode' from 0 to {}, found {}", kFan, mode));
      if (mode < kTriangles) {
        ++other_primitives_;
        continue;
      }
      if (source_.as_scene) {
        const std::string_view of_material = gltf_material_name(model_, primitive);
        const bool is_named = several && !of_material.empty();
        if (before == nullptr || material_of(*before) != material_of(primitive)) {
          add_part(is_named ? fmt::format("{} {}", name, of_material) : std::string(name),
                   gltf_material(model_, primitive, surface_.is_by_isoextract));
        }
        add_left_out(model_, primitive, surface_.left_out);
        before = &primitive;
      }
      add_primitive(primitive, mode, transform);
    }
  }

  // Returns how many triangles `corners` corners make in this mode.
  static std::uint64_t triangle_count(std::uint64_t mode, std::uint64_t corners, const char* what) {
    if (mode == kTriangles && corners % 3 != 0) {
      throw DamagedMesh(fmt::format("expected a multiple of three {} for triangles, found {}", what, corners));
    }
    if (mode != kTriangles && corners < 3) {
      throw DamagedMesh(fmt::format("expected at least three {} in a strip or fan, found {}", what, corners));
    }
    return mode == kTriangles ? corners / 3 : corners - 2;
  }

  // Returns the three corners of triangle t, as numbers within the primitive (glTF 2.0, 3.7.2.1).
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
    const bool is_soup = data_->unpack_draco(primitive);
    const GltfView places = data_->view(whole(*attributes, "POSITION"), "VEC3", 3);
    const bool is_quantized = places.component >= kGltfByte && places.component <= kGltfUnsignedShort;
    if (places.component != kGltfFloat && !(has_quantized_ && is_quantized)) {
      throw DamagedMesh(fmt::format(
          "expected positions of component type {} (float; integers only if the file requires {}), found {}",
          kGltfFloat, kQuantizationExtension, places.component));
    }
    const std::size_t first_vertex = surface_.positions.size();
    const std::size_t first_triangle = surface_.triangles.size();
    require_vertex_count(first_vertex + places.count);
    const std::vector<GltfView> views = attribute_views(*attributes, places.count);
    const bool is_indexed = primitive.contains("indices") && !is_soup;
    const auto extensions = primitive.find("extensions");
    const bool is_draco = extensions != primitive.end() && extensions->contains(kDracoExtension);
    const bool is_exact = places.component == kGltfFloat && !is_draco;
    surface_.is_quantized = surface_.is_quantized || !is_exact;
    if (is_indexed) {
      // Rounded positions can be equal although no vertex was duplicated.
      surface_.has_normals = surface_.has_normals || (is_exact && attributes->contains("NORMAL"));
      source_.memory.make_room(surface_.positions, places.count);
      for (std::uint64_t v = 0; v < places.count; ++v) surface_.positions.push_back(places.point(v));
      add_values(views, places.count, [](std::uint64_t v) { return v; });
      add_indexed(data_->view(whole(primitive, "indices"), "SCALAR", 1), mode, first_vertex, places.count);
    } else {
      add_corners(places, views, mode);
    }
    for (std::size_t v = first_vertex; v < surface_.positions.size(); ++v) {
      surface_.positions[v] = transform.linear * surface_.positions[v] + transform.offset;
    }
    if (source_.with_normals) {
      const auto corners = [&](std::uint64_t t) -> std::array<std::uint64_t, 3> {
        if (!is_indexed) return corners_of(mode, t);
        const glm::uvec3& triangle = surface_.triangles[first_triangle + t];
        return {triangle.x - first_vertex, triangle.y - first_vertex, triangle.z - first_vertex};
      };
      add_gltf_normals(*data_, *attributes, places.count, surface_.triangles.size() - first_triangle, corners,
                       transform, source_.memory, surface_.normals);
    }
    // A mirroring transform flips the winding, so this restores it (glTF 2.0, 3.7.4).
    if (glm::determinant(transform.linear) < 0) {
      for (std::size_t t = first_triangle; t < surface_.triangles.size(); ++t) {
        std::swap(surface_.triangles[t].y, surface_.triangles[t].z);
        if (source_.with_normals) std::swap(surface_.normals.numbers[t].y, surface_.normals.numbers[t].z);
      }
    }
  }

  void add_indexed(const GltfView& indices, std::uint64_t mode, std::size_t first_vertex, std::uint64_t vertices) {
    if (!indices.has_whole_numbers()) {
      throw DamagedMesh(
          fmt::format("expected indices of component type 5121, 5123 or 5125, found {}", indices.component));
    }
    const std::uint64_t triangles = triangle_count(mode, indices.count, "indices");
    const auto index_at = [&](std::uint64_t i) {
      const std::uint32_t index = indices.whole_number(i);
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
  std::span<const std::byte> binary_;  // the binary chunk of a .glb
  JsonTree tree_;
  const json& model_ = tree_.root();
  std::optional<GltfData> data_;  // set once the file's extensions are known to be supported
  bool has_quantized_ = false;    // KHR_mesh_quantization: positions may be integers
  std::uint64_t other_primitives_ = 0;
  bool is_first_primitive_ = true;
  std::set<std::string> left_out_;   // names of dropped attributes
  std::uint64_t corners_apart_ = 0;  // corners welded with a corner that has other attributes
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
      throw DamagedMesh(fmt::format(
          "expected a chunk of 8 + {} bytes at byte {}, found {} bytes up to the end of the file", bytes, at, left));
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

}  // namespace isoextract::mesh_io
