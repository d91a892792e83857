#include "mesh_io/write/gltf_model.hpp"

#include <cstddef>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/parallel.hpp"
#include "base/printable_json.hpp"
#include "base/version.hpp"
#include "mesh_io/detail/json_tree.hpp"
#include "mesh_io/detail/placement_entry.hpp"

namespace isoextract::mesh_io {
namespace {

// Returns the bounds of all triangle corners. The split layout does not write vertices that no triangle uses.
mesh::LocalBounds measure_corner_bounds(const mesh::Mesh& mesh) {
  const glm::vec3 some_corner = mesh.positions[mesh.triangles[0].x];
  const auto join = [](mesh::LocalBounds a, const mesh::LocalBounds& b) {
    return mesh::LocalBounds{glm::min(a.min, b.min), glm::max(a.max, b.max)};
  };
  return reduce_ranges(
      mesh.triangles.size(), 1 << 12, mesh::LocalBounds{some_corner, some_corner},
      [&](std::size_t begin, std::size_t end, mesh::LocalBounds bounds) {
        for (std::size_t t = begin; t != end; ++t) {
          for (int corner = 0; corner < 3; ++corner) {
            const glm::vec3& p = mesh.positions[mesh.triangles[t][corner]];
            bounds = join(bounds, {p, p});
          }
        }
        return bounds;
      },
      join);
}

// Returns the number of the list's last entry, counting the `taken` entries that were removed.
template <class List>
int last_number(std::size_t taken, const List& list) {
  return static_cast<int>(taken + list.size()) - 1;
}

// Returns TinyGLTF's JSON text of the model, without buffers. `placement` is MeshWriteOptions::placement.
std::string tinygltf_text(tinygltf::Model& model, const std::string& placement) {
  model.asset.generator = generator();
  model.asset.version = "2.0";
  std::ostringstream stream;
  tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, stream, false, false);
  std::string text = stream.str();
  // Inserts text before parsing, because adding members to a parsed document leaks memory if an allocation fails. Names
  // cannot contain these characters, as quotes in them are escaped.
  constexpr std::string_view kAsset = R"("asset":{)";
  if (const std::size_t asset = text.find(kAsset); !placement.empty() && asset != std::string::npos) {
    text.insert(asset + kAsset.size(), fmt::format(R"("extras":{{"{}":{}}},)", kPlacementEntry, placement));
  }
  return text;
}

// Replaces null, which TinyGLTF writes for a node without members and a scene without nodes, and which glTF forbids.
void fix_empty_entries(nlohmann::json& document) {
  for (const char* list : {"nodes", "scenes"}) {
    if (!document.contains(list)) continue;
    for (auto& entry : document[list]) {
      if (entry.is_null()) entry = nlohmann::json::object();
    }
  }
}

// Sets the node's translation and scale for packed positions.
void place_packed(const GltfPackedPart& packed, tinygltf::Node& node) {
  const glm::dvec3& origin = packed.translation;
  node.translation.clear();
  if (origin != glm::dvec3(0)) node.translation = {origin.x, origin.y, origin.z};
  if (packed.scale != 1) node.scale.assign(3, packed.scale);
}

}  // namespace

void GltfModel::add(const GltfPart& part) {
  constexpr std::size_t kNodesAtOnce = 128;
  constexpr std::size_t kPortionsAtOnce = 8;
  scene_.nodes.push_back(node(part));
  if (model_.nodes.size() < kNodesAtOnce) return;
  portions_.push_back(take_portion());
  if (portions_.size() == kPortionsAtOnce) convert_portions();
}

GltfModel::Portion GltfModel::take_portion() {
  Portion portion{std::exchange(model_, {}), std::exchange(meshopt_views_, {}), taken_.views};
  taken_ = {taken_.nodes + portion.model.nodes.size(), taken_.meshes + portion.model.meshes.size(),
            taken_.materials + portion.model.materials.size(), taken_.views + portion.model.bufferViews.size(),
            taken_.accessors + portion.model.accessors.size()};
  return portion;
}

nlohmann::json GltfModel::document_of(Portion& portion) const {
  JsonTree tree(nlohmann::json::parse(tinygltf_text(portion.model, placement_)));
  fix_empty_entries(tree.root());
  describe_packed_views(portion, tree.root());
  return std::move(tree.root());
}

void GltfModel::convert_portions() {
  std::vector<std::vector<JsonLists::Member>> members(portions_.size());
  for_each_index(portions_.size(), [&](std::size_t i) {
    if (portions_[i].meshopt_views.empty()) {
      members[i] = JsonLists::members_of_text(tinygltf_text(portions_[i].model, placement_));
      for (JsonLists::Member& member : members[i]) {
        if (member.name == "nodes" && member.text == "null") member.text = "{}";
        if (member.name == "asset") {  // the placement in it may have another order of members
          JsonTree asset(nlohmann::json::parse(member.text));
          member.text = printable_json(asset.root().dump());
        }
      }
      return;
    }
    JsonTree tree(document_of(portions_[i]));
    members[i] = JsonLists::members_of(tree.root());
  });
  for (std::vector<JsonLists::Member>& portion : members) earlier_.add(std::move(portion));
  portions_.clear();
}

int GltfModel::add_frame(const std::string& name, std::span<const GltfPart> parts, bool hidden) {
  tinygltf::Node frame;
  in_frame_ = true;
  for (const GltfPart& part : parts) {
    if (part.layout != GltfPart::Layout::nothing) frame.children.push_back(node(part));
  }
  // A node that already has a scale, as packed positions need, cannot be animated by scale.
  if (frame.children.size() == 1 && model_.nodes.back().scale.empty()) {
    frame = std::move(model_.nodes.back());
    model_.nodes.pop_back();
  }
  in_frame_ = false;
  frame.name = as_utf8(name);
  if (hidden) frame.scale = {0, 0, 0};
  return push(std::move(frame));
}

void GltfModel::flush(const std::function<void(nlohmann::json& document)>& look) {
  Portion portion = take_portion();
  JsonTree tree(document_of(portion));
  look(tree.root());
}

Notes GltfModel::release_notes() {
  Notes notes = std::exchange(notes_, {});
  if (has_split_) {
    notes.push_back({NoteId::flat_normals,
                     "glTF stores flat normals with three vertices per triangle, so the file has no welded vertices; "
                     "without normals the vertices stay welded, and viewers shade the mesh flat as well"});
  }
  return notes;
}

int GltfModel::push(tinygltf::Node node) {
  model_.nodes.push_back(std::move(node));
  return last_number(taken_.nodes, model_.nodes);
}

int GltfModel::node(const GltfPart& part) {
  const std::string name = as_utf8(part.mesh->name);
  if (name != part.mesh->name) {
    notes_.push_back(
        {NoteId::renamed_meshes,
         fmt::format("the writer replaces invalid bytes in the name of mesh \"{}\", since glTF requires UTF-8", name)});
  }
  has_split_ = has_split_ || part.layout == GltfPart::Layout::split;
  tinygltf::Node node;
  node.name = name;
  const glm::dvec3& origin = part.mesh->origin;
  if (origin != glm::dvec3(0)) node.translation = {origin.x, origin.y, origin.z};
  if (part.packed != nullptr) place_packed(*part.packed, node);
  if (part.layout != GltfPart::Layout::nothing) {
    tinygltf::Mesh mesh;
    mesh.name = name;
    mesh.primitives.push_back(part.packed != nullptr                   ? packed(part)
                              : part.layout == GltfPart::Layout::split ? split(part)
                                                                       : indexed(part));
    model_.meshes.push_back(std::move(mesh));
    node.mesh = last_number(taken_.meshes, model_.meshes);
  }
  return push(std::move(node));
}

std::string GltfModel::json(const std::string& uri, int indent, Notes& notes) {
  const Notes own = release_notes();
  notes.insert(notes.end(), own.begin(), own.end());
  model_.scenes = {scene_};
  model_.defaultScene = 0;
  convert_portions();
  Portion last = take_portion();
  JsonTree tree(document_of(last));
  nlohmann::json& document = tree.root();
  if (offset_ > 0) {
    document["buffers"] = nlohmann::json::array();
    nlohmann::json& buffer = document["buffers"].emplace_back(nlohmann::json::object());
    buffer["byteLength"] = offset_;
    if (!uri.empty()) buffer["uri"] = uri;
  }
  if (const nlohmann::json unpacked = unpacked_buffer(); !unpacked.is_null()) document["buffers"].push_back(unpacked);
  if (earlier_.empty()) return printable_json(document.dump(indent));
  earlier_.add(document);
  const std::string text = earlier_.take(JsonLists::MemberOrder::by_name);
  if (indent < 0) return text;
  JsonTree all(nlohmann::json::parse(text));
  return printable_json(all.root().dump(indent));
}

int GltfModel::material(const GltfPart& part) {
  const bool vertex_colors = part.has_colors();
  const std::optional<mesh::Material>& look = part.mesh->material;
  const std::string name = in_frame_ ? std::string() : as_utf8(part.mesh->name);
  std::vector<MaterialEntry>& of_name = materials_[name];
  for (const MaterialEntry& made : of_name) {
    if (made.vertex_colors == vertex_colors && made.look == look) return made.number;
  }
  constexpr double kLightGray = 0.8;
  const mesh::Material own = look.value_or(mesh::Material());
  const glm::dvec3 color = own.color.value_or(glm::dvec3(vertex_colors ? 1 : kLightGray));
  tinygltf::Material material;
  material.pbrMetallicRoughness.baseColorFactor = {color.x, color.y, color.z, own.opacity};
  material.pbrMetallicRoughness.metallicFactor = 0.0;
  material.pbrMetallicRoughness.roughnessFactor = 0.6;
  if (own.opacity < 1) material.alphaMode = "BLEND";
  material.doubleSided = own.double_sided;
  material.name = name;
  model_.materials.push_back(std::move(material));
  of_name.push_back({vertex_colors, look, last_number(taken_.materials, model_.materials)});
  return of_name.back().number;
}

int GltfModel::view(std::uint64_t bytes, int target, std::size_t stride) {
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = offset_;
  view.byteLength = bytes;
  view.byteStride = stride;
  view.target = target;
  offset_ += gltf_aligned(bytes);
  model_.bufferViews.push_back(std::move(view));
  return last_number(taken_.views, model_.bufferViews);
}

int GltfModel::accessor(int view, std::size_t offset, int component, int type, std::uint64_t count) {
  tinygltf::Accessor accessor;
  accessor.bufferView = view;
  accessor.byteOffset = offset;
  accessor.componentType = component;
  accessor.type = type;
  accessor.count = count;
  model_.accessors.push_back(std::move(accessor));
  return last_number(taken_.accessors, model_.accessors);
}

int GltfModel::vectors(int view, std::size_t offset, std::uint64_t count) {
  return accessor(view, offset, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, count);
}

int GltfModel::positions(int view, std::uint64_t count, const mesh::LocalBounds& bounds) {
  const int index = vectors(view, 0, count);
  tinygltf::Accessor& accessor = model_.accessors.back();
  accessor.minValues = {bounds.min.x, bounds.min.y, bounds.min.z};
  accessor.maxValues = {bounds.max.x, bounds.max.y, bounds.max.z};
  return index;
}

void GltfModel::attributes(const GltfPart& part, tinygltf::Primitive& primitive) {
  for (const GltfSemantic& semantic : part.semantics) {
    const mesh::Attribute* attribute = semantic.attribute;
    using Type = mesh::ComponentType;
    const std::size_t stride = semantic.stride();
    const bool padded = stride != attribute->stride();
    const int component = attribute->type == Type::i8    ? TINYGLTF_COMPONENT_TYPE_BYTE
                          : attribute->type == Type::u8  ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE
                          : attribute->type == Type::i16 ? TINYGLTF_COMPONENT_TYPE_SHORT
                          : attribute->type == Type::u16 ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                                                         : TINYGLTF_COMPONENT_TYPE_FLOAT;
    constexpr std::array kTypes{TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4};
    const std::uint64_t count = part.vertex_count();
    primitive.attributes[semantic.name] =
        accessor(view(count * stride, TINYGLTF_TARGET_ARRAY_BUFFER, padded ? stride : 0), 0, component,
                 kTypes[attribute->components - 1], count);
    model_.accessors.back().normalized = attribute->normalized;
  }
}

tinygltf::Primitive GltfModel::split(const GltfPart& part) {
  const std::uint64_t count = part.vertex_count();
  const int vertices = view(count * GltfPart::kSplitStride, TINYGLTF_TARGET_ARRAY_BUFFER, GltfPart::kSplitStride);
  tinygltf::Primitive primitive = triangles(part);
  primitive.attributes["POSITION"] = positions(vertices, count, measure_corner_bounds(*part.mesh));
  primitive.attributes["NORMAL"] = vectors(vertices, sizeof(glm::vec3), count);
  attributes(part, primitive);
  return primitive;
}

tinygltf::Primitive GltfModel::indexed(const GltfPart& part) {
  const std::uint64_t count = part.vertex_count();
  const std::uint64_t bytes = count * sizeof(glm::vec3);
  tinygltf::Primitive primitive = triangles(part);
  primitive.attributes["POSITION"] = positions(view(bytes, TINYGLTF_TARGET_ARRAY_BUFFER), count,
                                               part.bounds ? *part.bounds : mesh::measure_local_bounds(*part.mesh));
  if (part.has_normals()) {
    primitive.attributes["NORMAL"] = vectors(view(bytes, TINYGLTF_TARGET_ARRAY_BUFFER), 0, count);
  }
  attributes(part, primitive);
  primitive.indices =
      accessor(view(part.index_bytes(), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER), 0,
               part.short_indices ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
               TINYGLTF_TYPE_SCALAR, 3 * part.shape.triangles);
  return primitive;
}

tinygltf::Primitive GltfModel::triangles(const GltfPart& part) {
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = material(part);
  return primitive;
}

}  // namespace isoextract::mesh_io
