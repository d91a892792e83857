// glTF 2.0 (ISO/IEC 12113): TinyGLTF builds the model and its JSON; the binary part goes from the meshes' own buffers
// straight to the file. A mesh is planned before it is written, so that the JSON knows every offset: in a GLB, where it
// comes before the data, all of them are.
#include <array>
#include <initializer_list>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <tiny_gltf.h>
#include <nlohmann/json.hpp>

#include "base/version.hpp"
#include "mesh/metrics.hpp"
#include "meshes/detail/json_tree.hpp"
#include "meshes/write/gltf_part.hpp"
#include "meshes/write/mesh_format_writers.hpp"

namespace isoextract::meshes {
namespace {

// Of the corners of all triangles: vertices that no triangle uses are not written in the split layout.
mesh::LocalBounds measure_corner_bounds(const mesh::Mesh& mesh) {
  const glm::vec3 some_corner = mesh.positions[mesh.triangles[0].x];
  const auto join = [](mesh::LocalBounds a, const mesh::LocalBounds& b) {
    return mesh::LocalBounds{glm::min(a.min, b.min), glm::max(a.max, b.max)};
  };
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, mesh.triangles.size()), mesh::LocalBounds{some_corner, some_corner},
      [&](const tbb::blocked_range<std::size_t>& range, mesh::LocalBounds bounds) {
        for (std::size_t t = range.begin(); t != range.end(); ++t) {
          for (int corner = 0; corner < 3; ++corner) {
            const glm::vec3& p = mesh.positions[mesh.triangles[t][corner]];
            bounds = join(bounds, {p, p});
          }
        }
        return bounds;
      },
      join);
}

// Collects views and accessors in the order in which write_part() writes their bytes.
class ModelBuilder {
 public:
  void add(const GltfPart& part) {
    const std::string name = as_utf8(part.mesh->name);
    if (name != part.mesh->name) {
      notes_.push_back(
          fmt::format("the name of mesh \"{}\" is not UTF-8 as glTF demands: what is not was replaced", name));
    }
    has_split_ = has_split_ || part.layout == GltfPart::Layout::split;
    tinygltf::Node node;
    node.name = name;
    const glm::dvec3& origin = part.mesh->origin;
    if (origin != glm::dvec3(0)) node.translation = {origin.x, origin.y, origin.z};
    if (part.layout != GltfPart::Layout::nothing) {
      node.mesh = static_cast<int>(model_.meshes.size());
      tinygltf::Mesh mesh;
      mesh.name = name;
      mesh.primitives.push_back(part.layout == GltfPart::Layout::split ? split(part) : indexed(part));
      model_.meshes.push_back(std::move(mesh));
    }
    scene_.nodes.push_back(static_cast<int>(model_.nodes.size()));
    model_.nodes.push_back(std::move(node));
  }

  // The JSON text. Its one buffer is described to the library's JSON afterwards, as the library would want its bytes.
  [[nodiscard]] std::string json(const std::string& uri, int indent, Notes& notes) {
    notes.insert(notes.end(), notes_.begin(), notes_.end());
    if (has_split_) {
      notes.push_back(
          "glTF keeps flat normals as three vertices a triangle, so the mesh is not welded; without normals it is, and "
          "viewers shade it flat as well");
    }
    model_.asset.generator = generator();
    model_.asset.version = "2.0";
    model_.scenes = {scene_};
    model_.defaultScene = 0;
    std::ostringstream stream;
    tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, stream, false, false);
    JsonTree tree(nlohmann::json::parse(stream.str()));
    nlohmann::json& document = tree.root();
    // The library makes null, which glTF forbids, of a node without a name and of a scene without nodes.
    for (const char* list : {"nodes", "scenes"}) {
      if (!document.contains(list)) continue;
      for (auto& entry : document[list]) {
        if (entry.is_null()) entry = nlohmann::json::object();
      }
    }
    if (offset_ > 0) {
      document["buffers"] = nlohmann::json::array();
      nlohmann::json& buffer = document["buffers"].emplace_back(nlohmann::json::object());
      buffer["byteLength"] = offset_;
      if (!uri.empty()) buffer["uri"] = uri;
    }
    return document.dump(indent);
  }

 private:
  // The number of the material of meshes with or without colours, which are multiplied with it.
  int material(bool colours) {
    int& number = materials_[colours ? 1 : 0];
    if (number >= 0) return number;
    number = static_cast<int>(model_.materials.size());
    constexpr double kLightGrey = 0.8;
    const double grey = colours ? 1 : kLightGrey;
    tinygltf::Material material;
    material.pbrMetallicRoughness.baseColorFactor = {grey, grey, grey, 1.0};
    material.pbrMetallicRoughness.metallicFactor = 0.0;
    material.pbrMetallicRoughness.roughnessFactor = 0.6;
    model_.materials.push_back(std::move(material));
    return number;
  }

  // A view of the next `bytes` bytes.
  int view(std::uint64_t bytes, int target, std::size_t stride = 0) {
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = offset_;
    view.byteLength = bytes;
    view.byteStride = stride;
    view.target = target;
    offset_ += gltf_aligned(bytes);
    model_.bufferViews.push_back(std::move(view));
    return static_cast<int>(model_.bufferViews.size()) - 1;
  }

  int accessor(int view, std::size_t offset, int component, int type, std::uint64_t count) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.byteOffset = offset;
    accessor.componentType = component;
    accessor.type = type;
    accessor.count = count;
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  int vectors(int view, std::size_t offset, std::uint64_t count) {
    return accessor(view, offset, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, count);
  }

  int positions(int view, std::uint64_t count, const mesh::LocalBounds& bounds) {
    const int index = vectors(view, 0, count);
    tinygltf::Accessor& accessor = model_.accessors.back();
    accessor.minValues = {bounds.min.x, bounds.min.y, bounds.min.z};
    accessor.maxValues = {bounds.max.x, bounds.max.y, bounds.max.z};
    return index;
  }

  void attributes(const GltfPart& part, tinygltf::Primitive& primitive) {
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
      model_.accessors.back().normalized = attribute->normalised;
    }
  }

  tinygltf::Primitive split(const GltfPart& part) {
    const std::uint64_t count = part.vertex_count();
    const int vertices = view(count * GltfPart::kSplitStride, TINYGLTF_TARGET_ARRAY_BUFFER, GltfPart::kSplitStride);
    tinygltf::Primitive primitive = triangles(part.has_colours());
    primitive.attributes["POSITION"] = positions(vertices, count, measure_corner_bounds(*part.mesh));
    primitive.attributes["NORMAL"] = vectors(vertices, sizeof(glm::vec3), count);
    attributes(part, primitive);
    return primitive;
  }

  tinygltf::Primitive indexed(const GltfPart& part) {
    const std::uint64_t count = part.vertex_count();
    const std::uint64_t bytes = count * sizeof(glm::vec3);
    tinygltf::Primitive primitive = triangles(part.has_colours());
    primitive.attributes["POSITION"] =
        positions(view(bytes, TINYGLTF_TARGET_ARRAY_BUFFER), count, mesh::measure_local_bounds(*part.mesh));
    if (part.has_normals()) {
      primitive.attributes["NORMAL"] = vectors(view(bytes, TINYGLTF_TARGET_ARRAY_BUFFER), 0, count);
    }
    attributes(part, primitive);
    primitive.indices =
        accessor(view(part.index_bytes(), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER), 0,
                 part.short_indices ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                 TINYGLTF_TYPE_SCALAR, 3 * std::uint64_t{part.mesh->triangles.size()});
    return primitive;
  }

  tinygltf::Primitive triangles(bool colours) {
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = material(colours);
    return primitive;
  }

  tinygltf::Model model_;
  tinygltf::Scene scene_;
  std::uint64_t offset_ = 0;
  std::array<int, 2> materials_{-1, -1};  // without colours, with colours; -1: not made yet
  bool has_split_ = false;
  Notes notes_;  // of the meshes' names
};

class GlbWriter final : public FormatWriter {
 public:
  GlbWriter(bool flat_normals, files::OutputFile& file) : flat_normals_(flat_normals), file_(file) {}

  Result<void> add(const mesh::Mesh& mesh, Notes& notes) override {
    parts_.emplace_back(mesh, flat_normals_, notes);
    return {};
  }

  Result<void> finish(Notes& notes) override {
    constexpr std::uint64_t kHeaderBytes = 3 * sizeof(std::uint32_t);
    constexpr std::uint64_t kChunkHeaderBytes = 2 * sizeof(std::uint32_t);
    std::uint64_t binary_bytes = 0;
    for (const GltfPart& part : parts_) binary_bytes += part.bytes();
    // Once before the bounds of what would be too much are measured, and once exactly.
    if (auto fits = check_length(kHeaderBytes + 2 * kChunkHeaderBytes + binary_bytes); !fits) return fits;
    ModelBuilder builder;
    for (const GltfPart& part : parts_) builder.add(part);
    std::string json = builder.json({}, -1, notes);
    json.resize(gltf_aligned(json.size()), ' ');
    const std::uint64_t binary_chunk_bytes = binary_bytes > 0 ? kChunkHeaderBytes + binary_bytes : 0;
    const std::uint64_t length = kHeaderBytes + kChunkHeaderBytes + json.size() + binary_chunk_bytes;
    if (auto fits = check_length(length); !fits) return fits;

    constexpr std::uint32_t kMagic = 0x46546C67;  // "glTF"
    constexpr std::uint32_t kContainerVersion = 2;
    constexpr std::uint32_t kJson = 0x4E4F534A;    // "JSON"
    constexpr std::uint32_t kBinary = 0x004E4942;  // "BIN"
    auto written = write_words({kMagic, kContainerVersion, length, json.size(), kJson});
    if (written) written = file_.write(json);
    if (!written || binary_bytes == 0) return written;
    written = write_words({binary_bytes, kBinary});
    for (std::size_t p = 0; p < parts_.size() && written; ++p) written = write_part(parts_[p], file_);
    return written;
  }

 private:
  [[nodiscard]] Result<void> check_length(std::uint64_t length) const {
    if (length <= std::numeric_limits<std::uint32_t>::max()) return {};
    return fail(ErrorKind::output,
                fmt::format("{}: a .glb holds less than 4 GiB, this one needs {} bytes", file_.shown_name(), length),
                {Remedy::choose_mesh_format, "gltf or ply"});
  }

  Result<void> write_words(std::initializer_list<std::uint64_t> words) {
    Result<void> written;
    for (const std::uint64_t wide : words) {
      const auto word = static_cast<std::uint32_t>(wide);
      if (written) written = file_.write(std::as_bytes(std::span(&word, 1)));
    }
    return written;
  }

  bool flat_normals_;
  files::OutputFile& file_;
  std::vector<GltfPart> parts_;
};

class GltfWriter final : public FormatWriter {
 public:
  GltfWriter(bool flat_normals, files::OutputFile& model, files::OutputFile& binary, const std::string& binary_name)
      : flat_normals_(flat_normals), model_(model), binary_(binary) {
    for (const char c : binary_name) {
      const bool unreserved = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                              std::string_view("-._~").find(c) != std::string_view::npos;  // RFC 3986, 2.3
      uri_ += unreserved ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }

  Result<void> add(const mesh::Mesh& mesh, Notes& notes) override {
    const GltfPart part(mesh, flat_normals_, notes);
    builder_.add(part);
    return write_part(part, binary_);
  }

  Result<void> finish(Notes& notes) override {
    constexpr int kIndent = 2;
    return model_.write(builder_.json(uri_, kIndent, notes) + "\n");
  }

 private:
  bool flat_normals_;
  files::OutputFile& model_;
  files::OutputFile& binary_;
  std::string uri_;
  ModelBuilder builder_;
};

}  // namespace

std::unique_ptr<FormatWriter> make_glb_writer(const MeshWriteOptions& options, files::OutputFile& file) {
  return std::make_unique<GlbWriter>(options.flat_normals, file);
}

std::unique_ptr<FormatWriter> make_gltf_writer(const MeshWriteOptions& options, files::OutputFile& model,
                                               files::OutputFile& binary, const std::string& binary_name) {
  return std::make_unique<GltfWriter>(options.flat_normals, model, binary, binary_name);
}

}  // namespace isoextract::meshes
