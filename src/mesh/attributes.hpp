// Vertex attributes: named values besides the positions, as files store them.
//
// Normals are not among them. The extractors write normals in vectorized loops to a Buffer<glm::vec3>, formats store
// normals separately from attributes, and code that reads normals needs glm::vec3 without a search by name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

#include "base/buffer.hpp"

namespace isoextract::mesh {

struct Mesh;

// The types of PLY. glTF allows neither i32, u32 nor f64 in vertex attributes.
enum class ComponentType : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

[[nodiscard]] std::size_t component_size(ComponentType type);
// Returns a name such as "u8".
[[nodiscard]] std::string_view component_name(ComponentType type);

enum class AttributeRole : std::uint8_t {
  color,  // red, green, blue and optionally alpha: u8 or u16, normalized, or f32. At most one per mesh
  other   // identified by its name only
};

constexpr std::size_t kMaxComponents = 4;

struct Attribute {
  std::string name;  // the original name; writers adapt it to their format
  AttributeRole role = AttributeRole::other;
  ComponentType type = ComponentType::f32;
  std::size_t components = 1;  // at most kMaxComponents
  bool normalized = false;     // integers represent 0 .. 1, or -1 .. 1 if they are signed
  Buffer<std::byte> values;    // vertex by vertex, without gaps, in native byte order

  [[nodiscard]] std::size_t stride() const { return components * component_size(type); }
  [[nodiscard]] std::span<const std::byte> at(std::size_t vertex) const {
    return values.span().subspan(vertex * stride(), stride());
  }
  [[nodiscard]] Attribute without_values() const { return {name, role, type, components, normalized, {}}; }
};

// Decodes the component at `place`. A normalized integer i means max(i / largest integer of the type, -1) (glTF 2.0,
// 3.6.2.2). The flag has no effect on floats.
[[nodiscard]] double component_value(const std::byte* place, ComponentType type, bool normalized);

// A point on the edge between two vertices, at the fraction `t` of the way, from 0 to 1.
struct EdgePoint {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  double t = 0;
};

// Sets the value of `vertex` to that of `old` at a point on an edge. `old` has the form of `attribute`, and may be the
// same object. Interpolates floats, colors and normalized integers linearly. Other integers may be labels or numbers of
// objects, which have no values between them: they get the value of the nearer end, on a tie that of `from`.
void set_interpolated(Attribute& attribute, std::size_t vertex, const Attribute& old, const EdgePoint& point);

// Returns the unit normal at a point on an edge, by linear interpolation; the normal of `from` if they cancel out.
[[nodiscard]] glm::vec3 interpolated_normal(const Buffer<glm::vec3>& normals, const EdgePoint& point);

// Returns the bytes of one vertex in all arrays of the mesh.
[[nodiscard]] std::size_t vertex_bytes(const Mesh& mesh);

// Replaces the vertices: new vertex i is a copy of old vertex old_of_new[i]. Old vertices may occur several times or
// not at all. Does not change the triangles. If it throws std::bad_alloc, the mesh stays as it was. Needs
// vertex_bytes(mesh) for each new vertex while the old ones exist.
void gather_vertices(Mesh& mesh, std::span<const std::uint32_t> old_of_new);

// Returns a deep copy; the caller reserves its memory. Throws std::bad_alloc.
[[nodiscard]] Mesh copy(const Mesh& mesh);

}  // namespace isoextract::mesh
