// Attributes for test meshes, with values that differ between vertices and use all bits of their type.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "base/hash.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::test {

template <class T>
void add_values(mesh::Mesh& mesh, mesh::Attribute attribute) {
  std::vector<T> values;
  for (std::size_t i = 0; i < mesh.positions.size() * attribute.components; ++i) {
    // Floats are fractions without a short decimal form.
    values.push_back(std::is_floating_point_v<T> ? static_cast<T>(1) / static_cast<T>(i + 3)
                                                 : static_cast<T>(splitmix64(i)));
  }
  attribute.values = Buffer<std::byte>(values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(attribute.values.data(), values.data(), attribute.values.size());
  mesh.attributes.push_back(std::move(attribute));
}

inline void add_attribute(mesh::Mesh& mesh, std::string name, mesh::ComponentType type, std::size_t components,
                          bool normalized = false, mesh::AttributeRole role = mesh::AttributeRole::other) {
  using Type = mesh::ComponentType;
  mesh::Attribute attribute{std::move(name), role, type, components, normalized, {}};
  switch (type) {
    case Type::i8: return add_values<std::int8_t>(mesh, std::move(attribute));
    case Type::u8: return add_values<std::uint8_t>(mesh, std::move(attribute));
    case Type::i16: return add_values<std::int16_t>(mesh, std::move(attribute));
    case Type::u16: return add_values<std::uint16_t>(mesh, std::move(attribute));
    case Type::i32: return add_values<std::int32_t>(mesh, std::move(attribute));
    case Type::u32: return add_values<std::uint32_t>(mesh, std::move(attribute));
    case Type::f32: return add_values<float>(mesh, std::move(attribute));
    case Type::f64: return add_values<double>(mesh, std::move(attribute));
  }
}

inline void add_color(mesh::Mesh& mesh, mesh::ComponentType type, std::size_t components) {
  add_attribute(mesh, "color", type, components, type != mesh::ComponentType::f32, mesh::AttributeRole::color);
}

// Compares kinds and values, bit for bit.
inline bool same_attribute(const mesh::Attribute& a, const mesh::Attribute& b) {
  return a.name == b.name && a.role == b.role && a.type == b.type && a.components == b.components &&
         a.normalized == b.normalized && a.values.size() == b.values.size() &&
         (a.values.empty() || std::memcmp(a.values.data(), b.values.data(), a.values.size()) == 0);
}

}  // namespace isoextract::test
