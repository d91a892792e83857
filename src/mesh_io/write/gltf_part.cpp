#include "mesh_io/write/gltf_part.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/parallel.hpp"
#include "files/record_stream.hpp"
#include "mesh_io/write/gltf_packed_part.hpp"
#include "mesh_io/write/mesh_encoding.hpp"

namespace isoextract::mesh_io {
namespace {

using ShortTriangle = glm::vec<3, std::uint16_t>;

// glTF forbids infinite and NaN values in accessors (glTF 2.0, 3.6.2.2).
bool has_finite_values(const mesh::Attribute& attribute) {
  if (attribute.type != mesh::ComponentType::f32) return true;
  const std::size_t count = attribute.values.size() / sizeof(float);
  return reduce_ranges(
      count, 1 << 16, true,
      [&](std::size_t begin, std::size_t end, bool finite) {
        for (std::size_t i = begin; i != end && finite; ++i) {
          float value = 0;
          std::memcpy(&value, attribute.values.data() + i * sizeof value, sizeof value);
          finite = std::isfinite(value);
        }
        return finite;
      },
      [](bool a, bool b) { return a && b; });
}

// Returns the shape of a mesh, with MeshShape::not_finite_attributes.
mesh::MeshShape shape_with_attributes(const mesh::Mesh& mesh) {
  mesh::MeshShape shape = mesh::shape_of(mesh);
  for (std::size_t a = 0; a < mesh.attributes.size() && shape.triangles > 0; ++a) {
    if (!has_finite_values(mesh.attributes[a])) shape.not_finite_attributes.push_back(a);
  }
  return shape;
}

// `not_finite` is MeshShape::not_finite_attributes.
std::vector<GltfSemantic> semantics_of(const mesh::Mesh& mesh, std::span<const std::size_t> not_finite, Notes& notes) {
  std::vector<GltfSemantic> semantics;
  for (std::size_t a = 0; a < mesh.attributes.size(); ++a) {
    const mesh::Attribute& attribute = mesh.attributes[a];
    const std::string shown = as_utf8(attribute.name);
    const auto type = attribute.type;
    if (type == mesh::ComponentType::i32 || type == mesh::ComponentType::u32 || type == mesh::ComponentType::f64) {
      notes.push_back({NoteId::attribute_left_out,
                       fmt::format("glTF has no attributes of type {}: the writer omits '{}'; ply stores it",
                                   mesh::component_name(type), shown)});
      continue;
    }
    if (std::ranges::binary_search(not_finite, a)) {
      notes.push_back(
          {NoteId::attribute_left_out,
           fmt::format(
               "glTF has no infinite or NaN values: the writer omits the attribute '{}', which has such values; "
               "ply stores it",
               shown)});
      continue;
    }
    if (attribute.role == mesh::AttributeRole::color) {
      semantics.push_back({&attribute, "COLOR_0"});
      continue;
    }
    std::string name = "_" + shown;
    const auto is_taken = [&] {
      return std::any_of(semantics.begin(), semantics.end(), [&](const GltfSemantic& s) { return s.name == name; });
    };
    while (is_taken()) name += '_';
    if (name.substr(1) != attribute.name) {
      notes.push_back({NoteId::attribute_renamed, fmt::format("the writer renames the attribute '{}' to '{}': the name "
                                                              "is not valid UTF-8, or another attribute has it",
                                                              shown, name.substr(1))});
    }
    semantics.push_back({&attribute, std::move(name)});
  }
  return semantics;
}

Result<void> write_split(const mesh::Mesh& mesh, files::OutputFile& file) {
  constexpr std::size_t kRecord = 3 * GltfPart::kSplitStride;
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

Result<void> write_attributes(const GltfPart& part, files::OutputFile& file) {
  Result<void> written;
  for (const GltfSemantic& semantic : part.semantics) {
    if (!written) break;
    const bool split = part.layout == GltfPart::Layout::split;
    const std::size_t vertices = split ? 3 : 1;  // vertices per record
    written = files::write_records(file, part.vertex_count() / vertices, vertices * semantic.stride(),
                                   [&](std::size_t first, std::size_t last, char* out) {
                                     for (std::size_t i = first; i < last; ++i) {
                                       if (!split) {
                                         out = put_gltf_value(out, *semantic.attribute, i);
                                         continue;
                                       }
                                       const glm::uvec3 triangle = part.mesh->triangles[i];
                                       for (int c = 0; c < 3; ++c) {
                                         out = put_gltf_value(out, *semantic.attribute, triangle[c]);
                                       }
                                     }
                                     return out;
                                   });
  }
  return written;
}

Result<void> write_indices(const GltfPart& part, files::OutputFile& file) {
  const auto& triangles = part.mesh->triangles;
  if (!part.short_indices) return file.write(std::as_bytes(triangles.span()));
  auto written = files::write_records(file, triangles.size(), sizeof(ShortTriangle),
                                      [&](std::size_t first, std::size_t last, char* out) {
                                        for (std::size_t t = first; t < last; ++t) {
                                          out = put_bytes(out, ShortTriangle(triangles[t]));
                                        }
                                        return out;
                                      });
  constexpr std::array<std::byte, kGltfAlignment> kZeros{};
  const std::uint64_t bytes = part.index_bytes();
  return written ? file.write(std::span(kZeros).first(gltf_aligned(bytes) - bytes)) : written;
}

Result<void> write_padded(std::span<const std::byte> bytes, files::OutputFile& file) {
  constexpr std::array<std::byte, kGltfAlignment> kZeros{};
  auto written = file.write(bytes);
  return written ? file.write(std::span(kZeros).first(gltf_aligned(bytes.size()) - bytes.size())) : written;
}

}  // namespace

std::string as_utf8(const std::string& text) {
  const auto quoted = nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return nlohmann::json::parse(quoted).get<std::string>();
}

char* put_gltf_value(char* out, const mesh::Attribute& attribute, std::size_t vertex) {
  const std::span<const std::byte> value = attribute.at(vertex);
  std::memcpy(out, value.data(), value.size());
  char* const end = out + gltf_aligned(value.size());
  std::fill(out + value.size(), end, '\0');
  return end;
}

GltfPart::GltfPart(const mesh::Mesh& source, bool flat_normals, Notes& notes)
    : GltfPart(source, shape_with_attributes(source), notes) {
  if (layout == Layout::indexed && flat_normals) layout = Layout::split;
}

GltfPart::GltfPart(const mesh::Mesh& head, const mesh::MeshShape& shape_of_mesh, Notes& notes)
    : mesh(&head),
      shape(shape_of_mesh),
      layout(shape.triangles == 0 ? Layout::nothing : Layout::indexed),
      short_indices(layout == Layout::indexed && shape.vertices <= kMaxShortVertices) {
  if (layout != Layout::nothing) semantics = semantics_of(head, shape.not_finite_attributes, notes);
}

Result<GltfPart> GltfPart::make(const mesh::Mesh& source, const MeshWriteOptions& options, const Context& context,
                                Notes& notes) {
  GltfPart part(source, options.flat_normals, notes);
  if (!options.packing.packs() || part.layout == Layout::nothing) return part;
  auto packed = TRY(pack_part(part, options.packing, context));
  part.packed = std::make_shared<const GltfPackedPart>(std::move(packed));
  return part;
}

bool GltfPart::has_colors() const {
  return std::any_of(semantics.begin(), semantics.end(),
                     [](const GltfSemantic& s) { return s.attribute->role == mesh::AttributeRole::color; });
}

std::uint64_t GltfPart::vertex_count() const { return layout == Layout::split ? 3 * shape.triangles : shape.vertices; }

std::uint64_t GltfPart::index_bytes() const {
  return shape.triangles * (short_indices ? sizeof(ShortTriangle) : sizeof(glm::uvec3));
}

std::uint64_t GltfPart::bytes() const {
  if (layout == Layout::nothing) return 0;
  if (packed != nullptr) return packed->bytes();
  std::uint64_t attribute_bytes = 0;
  for (const GltfSemantic& semantic : semantics) attribute_bytes += vertex_count() * semantic.stride();
  if (layout == Layout::split) return vertex_count() * kSplitStride + attribute_bytes;
  return (has_normals() ? 2 : 1) * vertex_count() * sizeof(glm::vec3) + attribute_bytes + gltf_aligned(index_bytes());
}

Result<void> write_part(const GltfPart& part, files::OutputFile& file) {
  Result<void> written;
  if (part.packed != nullptr) {
    for (const GltfPackedView& view : part.packed->views) {
      if (written) written = write_padded(view.bytes, file);
    }
    return written;
  }
  if (part.layout == GltfPart::Layout::split) {
    written = write_split(*part.mesh, file);
    if (written) written = write_attributes(part, file);
  }
  if (part.layout == GltfPart::Layout::indexed) {
    written = file.write(std::as_bytes(part.mesh->positions.span()));
    if (written && part.has_normals()) written = file.write(std::as_bytes(part.mesh->normals.span()));
    if (written) written = write_attributes(part, file);
    if (written) written = write_indices(part, file);
  }
  return written;
}

}  // namespace isoextract::mesh_io
