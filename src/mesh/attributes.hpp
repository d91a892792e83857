// What vertices carry besides their place: named values, as files have them.
//
// Normals are not among them. The extractors write them from vectorised loops into a Buffer<glm::vec3>, every format
// has a place of its own for them, and what reads them wants vectors; a list to search would cost all of that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/buffer.hpp"

namespace isoextract::mesh {

struct Mesh;

// What PLY knows. glTF has no i32, u32 and f64 for what belongs to vertices.
enum class ComponentType : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

[[nodiscard]] std::size_t component_size(ComponentType type);
// "u8"
[[nodiscard]] std::string_view component_name(ComponentType type);

enum class AttributeRole : std::uint8_t {
  colour,  // red, green, blue and perhaps alpha: u8 or u16, normalised, or f32. At most one a mesh
  other    // known by its name alone
};

constexpr std::size_t kMaxComponents = 4;

struct Attribute {
  std::string name;  // as it was given; writers make of it what their format can have
  AttributeRole role = AttributeRole::other;
  ComponentType type = ComponentType::f32;
  std::size_t components = 1;  // at most kMaxComponents
  bool normalised = false;     // integers that stand for 0 .. 1, or -1 .. 1 where they are signed
  Buffer<std::byte> values;    // vertex after vertex, without gaps; numbers as the machine has them

  [[nodiscard]] std::size_t stride() const { return components * component_size(type); }
  [[nodiscard]] std::span<const std::byte> at(std::size_t vertex) const {
    return values.span().subspan(vertex * stride(), stride());
  }
  [[nodiscard]] Attribute without_values() const { return {name, role, type, components, normalised, {}}; }
};

// What a component that is stored at `place` stands for: the number itself, or where `normalised` the fraction of the
// greatest integer of its type, at least -1 (glTF 2.0, 3.6.2.2). For floats `normalised` says nothing.
[[nodiscard]] double component_value(const std::byte* place, ComponentType type, bool normalised);

// What one vertex takes in all arrays of the mesh.
[[nodiscard]] std::size_t vertex_bytes(const Mesh& mesh);

// Replaces the vertices: new vertex i has all that belonged to vertex old_of_new[i], which may be named several times,
// or not at all. Triangles are left to the caller. Throws std::bad_alloc, and then leaves the mesh as it was; it takes
// vertex_bytes(mesh) for each new vertex beside the old ones.
void gather_vertices(Mesh& mesh, std::span<const std::uint32_t> old_of_new);

// Throws std::bad_alloc. What memory the copy takes is the caller's to reserve.
[[nodiscard]] Mesh copy(const Mesh& mesh);

}  // namespace isoextract::mesh
