// glTF 2.0 (ISO/IEC 12113): TinyGLTF builds the model and its JSON; the binary part goes from the meshes' own buffers
// straight to the file. Meshes are planned first, so that the JSON, which comes before the data, knows every offset.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
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
#include "files/record_stream.hpp"
#include "mesh/metrics.hpp"
#include "meshes/write/mesh_encoding.hpp"
#include "meshes/write/mesh_format_writers.hpp"

namespace isoextract::meshes {
namespace {

using ShortTriangle = glm::vec<3, std::uint16_t>;

constexpr std::uint64_t kAlignment = 4;

std::uint64_t aligned(std::uint64_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

// JSON holds Unicode only; every byte that is no part of UTF-8 becomes U+FFFD.
std::string as_utf8(const std::string& text) {
  const auto quoted = nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return nlohmann::json::parse(quoted).get<std::string>();
}

// glTF 2.0, 3.6.2.2: no value of an accessor is infinite or NaN.
bool has_finite_values(const mesh::Attribute& attribute) {
  if (attribute.type != mesh::ComponentType::f32) return true;
  const std::size_t count = attribute.values.size() / sizeof(float);
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, count, 1 << 16), true,
      [&](const tbb::blocked_range<std::size_t>& range, bool finite) {
        for (std::size_t i = range.begin(); i != range.end() && finite; ++i) {
          float value = 0;
          std::memcpy(&value, attribute.values.data() + i * sizeof value, sizeof value);
          finite = std::isfinite(value);
        }
        return finite;
      },
      [](bool a, bool b) { return a && b; });
}

// An attribute that is written, and what glTF calls it: COLOR_0, or its name behind an underscore. Upper case is a
// custom there, and no rule: names stay as they are, so that they come back.
struct Semantic {
  const mesh::Attribute* attribute;
  std::string name;

  // Each value starts at a multiple of four bytes; glTF 2.0, 3.6.2.4.
  [[nodiscard]] std::size_t stride() const { return aligned(attribute->stride()); }
};

std::vector<Semantic> semantics_of(const mesh::Mesh& mesh, Notes& notes) {
  std::vector<Semantic> semantics;
  for (const mesh::Attribute& attribute : mesh.attributes) {
    const std::string shown = as_utf8(attribute.name);
    const auto type = attribute.type;
    if (type == mesh::ComponentType::i32 || type == mesh::ComponentType::u32 || type == mesh::ComponentType::f64) {
      notes.push_back(fmt::format("glTF has no attributes of type {}: '{}' was left out; ply keeps it",
                                  mesh::component_name(type), shown));
      continue;
    }
    if (!has_finite_values(attribute)) {
      notes.push_back(
          fmt::format("glTF has no numbers that are infinite or NaN: the attribute '{}', which has some, was left out; "
                      "ply keeps it",
                      shown));
      continue;
    }
    if (attribute.role == mesh::AttributeRole::colour) {
      semantics.push_back({&attribute, "COLOR_0"});
      continue;
    }
    std::string name = "_" + shown;
    const auto is_taken = [&] {
      return std::any_of(semantics.begin(), semantics.end(), [&](const Semantic& s) { return s.name == name; });
    };
    while (is_taken()) name += '_';
    if (name.substr(1) != attribute.name) {
      notes.push_back(fmt::format("the attribute '{}' is called '{}': glTF cannot call it so", shown, name.substr(1)));
    }
    semantics.push_back({&attribute, std::move(name)});
  }
  return semantics;
}

// How one mesh lies in the binary part: its vertices, their attributes one after another, then its indices.
struct Part {
  const mesh::Mesh* mesh = nullptr;
  std::vector<Semantic> semantics;
  enum class Layout {
    nothing,  // no triangles: glTF has no empty accessors
    split,    // three vertices a triangle, position and face normal interleaved, no indices
    indexed,  // positions, normals if any, indices
  } layout = Layout::nothing;
  bool short_indices = false;

  // 65535 restarts primitives and is no index.
  static constexpr std::size_t kMaxShortVertices = 65535;
  static constexpr std::size_t kSplitStride = 2 * sizeof(glm::vec3);

  Part(const mesh::Mesh& source, bool flat_normals, Notes& notes) : mesh(&source) {
    if (source.triangles.empty()) return;
    semantics = semantics_of(source, notes);
    layout = flat_normals ? Layout::split : Layout::indexed;
    short_indices = source.positions.size() <= kMaxShortVertices;
  }

  [[nodiscard]] bool has_normals() const { return !mesh->normals.empty(); }
  [[nodiscard]] std::uint64_t vertex_count() const {
    return layout == Layout::split ? 3 * std::uint64_t{mesh->triangles.size()} : mesh->positions.size();
  }
  [[nodiscard]] std::uint64_t index_bytes() const {
    return mesh->triangles.size() * (short_indices ? sizeof(ShortTriangle) : sizeof(glm::uvec3));
  }
  [[nodiscard]] std::uint64_t bytes() const {
    if (layout == Layout::nothing) return 0;
    std::uint64_t attribute_bytes = 0;
    for (const Semantic& semantic : semantics) attribute_bytes += vertex_count() * semantic.stride();
    if (layout == Layout::split) return vertex_count() * kSplitStride + attribute_bytes;
    return (has_normals() ? 2 : 1) * vertex_count() * sizeof(glm::vec3) + attribute_bytes + aligned(index_bytes());
  }
  [[nodiscard]] bool has_colours() const {
    return std::any_of(semantics.begin(), semantics.end(),
                       [](const Semantic& s) { return s.attribute->role == mesh::AttributeRole::colour; });
  }
};

std::vector<Part> plan(std::span<const mesh::Mesh> meshes, bool flat_normals, Notes& notes) {
  std::vector<Part> parts;
  for (const mesh::Mesh& mesh : meshes) parts.emplace_back(mesh, flat_normals, notes);
  return parts;
}

std::uint64_t total_bytes(const std::vector<Part>& parts) {
  std::uint64_t bytes = 0;
  for (const Part& part : parts) bytes += part.bytes();
  return bytes;
}

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

// Collects views and accessors in the order in which write_binary writes their bytes.
class ModelBuilder {
 public:
  void add(const Part& part, const std::string& name) {
    tinygltf::Node node;
    node.name = name;
    const glm::dvec3& origin = part.mesh->origin;
    if (origin != glm::dvec3(0)) node.translation = {origin.x, origin.y, origin.z};
    if (part.layout != Part::Layout::nothing) {
      node.mesh = static_cast<int>(model_.meshes.size());
      tinygltf::Mesh mesh;
      mesh.name = name;
      mesh.primitives.push_back(part.layout == Part::Layout::split ? split(part) : indexed(part));
      model_.meshes.push_back(std::move(mesh));
    }
    scene_.nodes.push_back(static_cast<int>(model_.nodes.size()));
    model_.nodes.push_back(std::move(node));
  }

  // The JSON text. Its one buffer is described to the library's JSON afterwards, as the library would want its bytes.
  [[nodiscard]] std::string json(std::uint64_t binary_bytes, const std::string& uri, int indent) {
    model_.asset.generator = generator();
    model_.asset.version = "2.0";
    model_.scenes = {scene_};
    model_.defaultScene = 0;
    std::ostringstream stream;
    tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, stream, false, false);
    auto document = nlohmann::json::parse(stream.str());
    // The library makes null, which glTF forbids, of a node without a name and of a scene without nodes.
    for (const char* list : {"nodes", "scenes"}) {
      if (!document.contains(list)) continue;
      for (auto& entry : document[list]) {
        if (entry.is_null()) entry = nlohmann::json::object();
      }
    }
    if (binary_bytes > 0) {
      nlohmann::json buffer = {{"byteLength", binary_bytes}};
      if (!uri.empty()) buffer["uri"] = uri;
      document["buffers"] = {buffer};
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
    offset_ += aligned(bytes);
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

  void attributes(const Part& part, tinygltf::Primitive& primitive) {
    for (const auto& [attribute, name] : part.semantics) {
      using Type = mesh::ComponentType;
      const bool padded = aligned(attribute->stride()) != attribute->stride();
      const std::size_t stride = aligned(attribute->stride());
      const int component = attribute->type == Type::i8    ? TINYGLTF_COMPONENT_TYPE_BYTE
                            : attribute->type == Type::u8  ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE
                            : attribute->type == Type::i16 ? TINYGLTF_COMPONENT_TYPE_SHORT
                            : attribute->type == Type::u16 ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                                                           : TINYGLTF_COMPONENT_TYPE_FLOAT;
      constexpr std::array kTypes{TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4};
      const std::uint64_t count = part.vertex_count();
      primitive.attributes[name] = accessor(view(count * stride, TINYGLTF_TARGET_ARRAY_BUFFER, padded ? stride : 0), 0,
                                            component, kTypes[attribute->components - 1], count);
      model_.accessors.back().normalized = attribute->normalised;
    }
  }

  tinygltf::Primitive split(const Part& part) {
    const std::uint64_t count = part.vertex_count();
    const int vertices = view(count * Part::kSplitStride, TINYGLTF_TARGET_ARRAY_BUFFER, Part::kSplitStride);
    tinygltf::Primitive primitive = triangles(part.has_colours());
    primitive.attributes["POSITION"] = positions(vertices, count, measure_corner_bounds(*part.mesh));
    primitive.attributes["NORMAL"] = vectors(vertices, sizeof(glm::vec3), count);
    attributes(part, primitive);
    return primitive;
  }

  tinygltf::Primitive indexed(const Part& part) {
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
};

std::string make_json(const std::vector<Part>& parts, const std::string& uri, int indent, Notes& notes) {
  ModelBuilder builder;
  for (const Part& part : parts) {
    const std::string name = as_utf8(part.mesh->name);
    if (name != part.mesh->name) {
      notes.push_back(
          fmt::format("the name of mesh \"{}\" is not UTF-8 as glTF demands: what is not was replaced", name));
    }
    builder.add(part, name);
  }
  if (std::any_of(parts.begin(), parts.end(), [](const Part& p) { return p.layout == Part::Layout::split; })) {
    notes.push_back(
        "glTF keeps flat normals as three vertices a triangle, so the mesh is not welded; without normals it is, and "
        "viewers shade it flat as well");
  }
  return builder.json(total_bytes(parts), uri, indent);
}

Result<void> write_split(const mesh::Mesh& mesh, files::OutputFile& file) {
  constexpr std::size_t kRecord = 3 * Part::kSplitStride;
  return files::write_records(file, mesh.triangles.size(), kRecord,
                              [&](std::size_t first, std::size_t last, char* out) {
                                for (std::size_t t = first; t < last; ++t) {
                                  const glm::uvec3 triangle = mesh.triangles[t];
                                  const glm::vec3 normal = face_normal(mesh, triangle);
                                  for (int corner = 0; corner < 3; ++corner) {
                                    out = put_bytes(put_bytes(out, mesh.positions[triangle[corner]]), normal);
                                  }
                                }
                                return out;
                              });
}

// Padded to the stride.
char* put_value(char* out, const Semantic& semantic, std::uint32_t vertex) {
  const mesh::Attribute& attribute = *semantic.attribute;
  std::memcpy(out, attribute.values.data() + vertex * attribute.stride(), attribute.stride());
  std::fill(out + attribute.stride(), out + semantic.stride(), '\0');
  return out + semantic.stride();
}

Result<void> write_attributes(const Part& part, files::OutputFile& file) {
  Result<void> written;
  for (const Semantic& semantic : part.semantics) {
    if (!written) break;
    const bool split = part.layout == Part::Layout::split;
    const std::size_t vertices = split ? 3 : 1;  // a record
    written = files::write_records(file, part.vertex_count() / vertices, vertices * semantic.stride(),
                                   [&](std::size_t first, std::size_t last, char* out) {
                                     for (std::size_t i = first; i < last; ++i) {
                                       if (!split) {
                                         out = put_value(out, semantic, static_cast<std::uint32_t>(i));
                                         continue;
                                       }
                                       const glm::uvec3 triangle = part.mesh->triangles[i];
                                       for (int c = 0; c < 3; ++c) out = put_value(out, semantic, triangle[c]);
                                     }
                                     return out;
                                   });
  }
  return written;
}

Result<void> write_indices(const Part& part, files::OutputFile& file) {
  const auto& triangles = part.mesh->triangles;
  if (!part.short_indices) return file.write(std::as_bytes(triangles.span()));
  auto written = files::write_records(file, triangles.size(), sizeof(ShortTriangle),
                                      [&](std::size_t first, std::size_t last, char* out) {
                                        for (std::size_t t = first; t < last; ++t) {
                                          out = put_bytes(out, ShortTriangle(triangles[t]));
                                        }
                                        return out;
                                      });
  constexpr std::array<std::byte, kAlignment> kZeros{};
  const std::uint64_t bytes = part.index_bytes();
  return written ? file.write(std::span(kZeros).first(aligned(bytes) - bytes)) : written;
}

Result<void> write_binary(const std::vector<Part>& parts, files::OutputFile& file) {
  Result<void> written;
  for (const Part& part : parts) {
    if (part.layout == Part::Layout::split) {
      written = write_split(*part.mesh, file);
      if (written) written = write_attributes(part, file);
    }
    if (part.layout == Part::Layout::indexed) {
      written = file.write(std::as_bytes(part.mesh->positions.span()));
      if (written && part.has_normals()) written = file.write(std::as_bytes(part.mesh->normals.span()));
      if (written) written = write_attributes(part, file);
      if (written) written = write_indices(part, file);
    }
    if (!written) break;
  }
  return written;
}

}  // namespace

Result<void> write_glb(std::span<const mesh::Mesh> meshes, const MeshWriteOptions& options, files::OutputFile& file,
                       Notes& notes) {
  constexpr std::uint64_t kHeaderBytes = 3 * sizeof(std::uint32_t);
  constexpr std::uint64_t kChunkHeaderBytes = 2 * sizeof(std::uint32_t);
  const std::vector<Part> parts = plan(meshes, options.flat_normals, notes);
  const std::uint64_t binary_bytes = total_bytes(parts);
  const auto check_length = [&](std::uint64_t length) -> Result<void> {
    if (length <= std::numeric_limits<std::uint32_t>::max()) return {};
    return fail(ErrorKind::output,
                fmt::format("{}: a .glb holds less than 4 GiB, this one needs {} bytes", file.shown_name(), length),
                {Remedy::choose_mesh_format, "gltf or ply"});
  };
  // Once before the bounds of what would be too much are measured, and once exactly.
  if (auto fits = check_length(kHeaderBytes + 2 * kChunkHeaderBytes + binary_bytes); !fits) return fits;
  std::string json = make_json(parts, {}, -1, notes);
  json.resize(aligned(json.size()), ' ');
  const std::uint64_t binary_chunk_bytes = binary_bytes > 0 ? kChunkHeaderBytes + binary_bytes : 0;
  const std::uint64_t length = kHeaderBytes + kChunkHeaderBytes + json.size() + binary_chunk_bytes;
  if (auto fits = check_length(length); !fits) return fits;

  const auto write_words = [&](std::initializer_list<std::uint64_t> words) {
    Result<void> written;
    for (const std::uint64_t wide : words) {
      const auto word = static_cast<std::uint32_t>(wide);
      if (written) written = file.write(std::as_bytes(std::span(&word, 1)));
    }
    return written;
  };
  constexpr std::uint32_t kMagic = 0x46546C67;  // "glTF"
  constexpr std::uint32_t kContainerVersion = 2;
  constexpr std::uint32_t kJson = 0x4E4F534A;    // "JSON"
  constexpr std::uint32_t kBinary = 0x004E4942;  // "BIN"
  auto written = write_words({kMagic, kContainerVersion, length, json.size(), kJson});
  if (written) written = file.write(json);
  if (!written || binary_bytes == 0) return written;
  written = write_words({binary_bytes, kBinary});
  return written ? write_binary(parts, file) : written;
}

Result<void> write_gltf(std::span<const mesh::Mesh> meshes, const MeshWriteOptions& options, files::OutputFile& model,
                        files::OutputFile& binary, const std::string& binary_name, Notes& notes) {
  const std::vector<Part> parts = plan(meshes, options.flat_normals, notes);
  std::string uri;
  for (const char c : binary_name) {
    const bool unreserved = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                            std::string_view("-._~").find(c) != std::string_view::npos;  // RFC 3986, 2.3
    uri += unreserved ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  constexpr int kIndent = 2;
  auto written = model.write(make_json(parts, uri, kIndent, notes) + "\n");
  return written ? write_binary(parts, binary) : written;
}

}  // namespace isoextract::meshes
