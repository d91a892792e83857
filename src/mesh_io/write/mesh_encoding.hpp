// Helpers shared by the mesh writers: values as bytes or as text, and face normals.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <string>
#include <string_view>
#include <type_traits>

#include <glm/glm.hpp>

#include "mesh/mesh.hpp"
#include "mesh_io/write/number_text.hpp"

namespace isoextract::mesh_io {

static_assert(std::endian::native == std::endian::little, "every binary mesh format here is little-endian");

template <class T>
char* put_bytes(char* out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::memcpy(out, &value, sizeof(T));
  return out + sizeof(T);
}

inline char* put_text(char* out, std::string_view text) { return std::copy(text.begin(), text.end(), out); }

// Writes " x y z" and returns the end.
template <class T>
char* put_vector(char* out, const glm::vec<3, T>& v) {
  for (int axis = 0; axis < 3; ++axis) {
    *out++ = ' ';
    out = put_number(out, v[axis]);
  }
  return out;
}
template <class T>
inline constexpr std::size_t kMaxVectorText = 3 * (1 + kMaxNumberText<T>);

// Calls f with a function that returns a vertex's world position: as stored float32 if the mesh has no origin,
// otherwise in double. So the files of a mesh without an origin have exactly its stored numbers.
template <class F>
decltype(auto) with_world_positions(const mesh::Mesh& mesh, F&& f) {
  if (mesh.origin == glm::dvec3(0)) return f([&mesh](std::size_t vertex) { return mesh.positions[vertex]; });
  return f([&mesh](std::size_t vertex) { return mesh.position(vertex); });
}

// Returns the unit normal of a triangle, outward by its winding; (0, 0, 1) for a triangle without area, since glTF
// allows only unit vectors. Computes in double, where nothing overflows or underflows.
inline glm::vec3 face_normal(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double length = glm::length(normal);
  return length > 0 ? glm::vec3(normal / length) : glm::vec3(0, 0, 1);
}
inline glm::vec3 face_normal(const mesh::Mesh& mesh, const glm::uvec3& triangle) {
  return face_normal(mesh.positions[triangle.x], mesh.positions[triangle.y], mesh.positions[triangle.z]);
}

inline double degrees_between(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / std::numbers::pi;
}

// Returns the name as one line of text: control characters, including line ends, become blanks.
inline std::string one_line(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }, ' ');
  return name;
}

}  // namespace isoextract::mesh_io
