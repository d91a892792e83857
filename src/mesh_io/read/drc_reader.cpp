// Draco files. Their float32 positions are kept unchanged.
#include "mesh_io/read/draco_vertices.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include <fmt/format.h>

namespace isoextract::mesh_io {
namespace {

// Returns the mesh attribute for a Draco attribute, without values.
mesh::Attribute kind_of(const DracoAttribute& attribute, std::size_t number) {
  mesh::Attribute kind;
  kind.name = !attribute.name.empty() ? attribute.name
              : attribute.is_color    ? "color"
                                      : fmt::format("attribute_{}", number);
  kind.type = attribute.type;
  kind.components = attribute.components;
  kind.normalized = attribute.normalized;
  using Type = mesh::ComponentType;
  const bool fraction = attribute.normalized && (kind.type == Type::u8 || kind.type == Type::u16);
  if (attribute.is_color && kind.components >= 3 && (fraction || kind.type == Type::f32)) {
    kind.role = mesh::AttributeRole::color;
  }
  return kind;
}

// With `is_soup`, no two triangles share a vertex: the vertices are the triangle corners in order.
void add_normals(const DracoSurface& unpacked, std::span<const std::uint32_t> vertices, bool is_soup, MemoryUse& memory,
                 FileSurface& surface) {
  const auto normals = std::ranges::find_if(unpacked.attributes, &DracoAttribute::is_normal);
  if (normals == unpacked.attributes.end() || normals->type != mesh::ComponentType::f32 || normals->components != 3) {
    return;
  }
  std::vector<glm::vec3>& values = surface.normals.values;
  const std::size_t count = is_soup ? unpacked.vertices : vertices.size();
  memory.make_room(values, count);
  for (std::size_t i = 0; i < count; ++i) {
    glm::vec3 normal;
    std::memcpy(&normal, normals->values.data() + (is_soup ? i : vertices[i]) * sizeof normal, sizeof normal);
    values.push_back(normal);
  }
  if (!is_soup) return;
  memory.make_room(surface.normals.numbers, count / 3);
  for (std::uint32_t c = 0; c + 2 < count; c += 3) surface.normals.numbers.emplace_back(c, c + 1, c + 2);
}

}  // namespace

DracoSurface unpack_draco_surface(std::span<const std::byte> bytes, MemoryUse& memory) {
  auto surface = decode_draco(bytes, [&](std::uint64_t more) { memory.take(more); });
  if (!surface) throw DamagedMesh(surface.error().message, surface.error().hint);
  return std::move(*surface);
}

bool order_as_corners(DracoSurface& surface, MemoryUse& memory) {
  if (surface.vertices != 3 * surface.triangles.size()) return false;
  memory.take(surface.vertices);
  std::vector<bool> met(surface.vertices);
  for (const glm::uvec3& triangle : surface.triangles) {
    for (int c = 0; c < 3; ++c) {
      if (met[triangle[c]]) return false;
      met[triangle[c]] = true;
    }
  }
  for (DracoAttribute& attribute : surface.attributes) {
    const std::size_t stride = attribute.components * mesh::component_size(attribute.type);
    memory.take(attribute.values.size());
    std::vector<std::byte> ordered(attribute.values.size());
    std::byte* out = ordered.data();
    for (const glm::uvec3& triangle : surface.triangles) {
      for (int c = 0; c < 3; ++c) {
        std::memcpy(out, attribute.values.data() + triangle[c] * stride, stride);
        out += stride;
      }
    }
    attribute.values = std::move(ordered);
    memory.give_back(attribute.values.size());
  }
  std::uint32_t next = 0;
  for (glm::uvec3& triangle : surface.triangles) {
    triangle = glm::uvec3(next, next + 1, next + 2);
    next += 3;
  }
  return true;
}

FileSurface read_drc(const MeshSource& source) {
  if (!is_draco(source.content)) {
    throw DamagedMesh(
        fmt::format("expected a Draco file, found one that starts with '{}'", files::printable(source.text(), 16)));
  }
  DracoSurface unpacked = unpack_draco_surface(source.content, source.memory);
  const bool is_soup = order_as_corners(unpacked, source.memory);
  const auto positions = std::ranges::find_if(unpacked.attributes, &DracoAttribute::is_position);
  if (positions == unpacked.attributes.end() || positions->type != mesh::ComponentType::f32 ||
      positions->components != 3) {
    throw DamagedMesh("expected positions of three float32 numbers in a Draco file, found none");
  }
  const auto position_at = [&](std::size_t v) {
    glm::vec3 position;
    std::memcpy(&position, positions->values.data() + v * sizeof position, sizeof position);
    return position;
  };
  FileSurface surface;
  surface.format = "Draco";
  surface.is_quantized = true;
  surface.is_by_isoextract = is_signature(unpacked.generator);
  surface.placement = unpacked.placement;
  // For each vertex of the surface, its first vertex in the file.
  std::vector<std::uint32_t> vertices;
  if (is_soup) {
    std::vector<glm::vec3> corners;
    source.memory.make_room(corners, unpacked.vertices);
    for (std::size_t v = 0; v < unpacked.vertices; ++v) corners.push_back(position_at(v));
    vertices = weld_corners(corners, surface, source.memory);
  } else {
    source.memory.make_room(surface.positions, unpacked.vertices);
    source.memory.make_room(vertices, unpacked.vertices);
    for (std::uint32_t v = 0; v < unpacked.vertices; ++v) {
      surface.positions.emplace_back(position_at(v));
      vertices.push_back(v);
    }
    surface.triangles = std::move(unpacked.triangles);
  }
  if (source.with_normals) add_normals(unpacked, vertices, is_soup, source.memory, surface);
  bool has_colors = false;
  for (std::size_t a = 0; a < unpacked.attributes.size(); ++a) {
    const DracoAttribute& attribute = unpacked.attributes[a];
    if (attribute.is_normal) surface.left_out.insert("normals");
    if (&attribute == &*positions || attribute.is_normal) continue;
    if (attribute.components > mesh::kMaxComponents) {
      surface.notes.push_back(
          {NoteId::data_left_out, fmt::format("the reader skips an attribute of {} components", attribute.components)});
      continue;
    }
    FileAttribute& made = surface.attributes.emplace_back();
    made.kind = kind_of(attribute, a);
    if (std::exchange(has_colors, has_colors || made.kind.role == mesh::AttributeRole::color)) {
      made.kind.role = mesh::AttributeRole::other;  // at most one color attribute per mesh
    }
    const std::size_t stride = made.kind.stride();
    source.memory.make_room(made.values, vertices.size() * stride);
    for (const std::uint32_t v : vertices) {
      const std::byte* value = attribute.values.data() + v * stride;
      made.values.insert(made.values.end(), value, value + stride);
    }
  }
  return surface;
}

}  // namespace isoextract::mesh_io
