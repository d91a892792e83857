#include "mesh/attributes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {
namespace {

struct ComponentInfo {
  std::string_view name;
  std::size_t size;
};
constexpr std::array<ComponentInfo, 8> kComponents{
    {{"i8", 1}, {"u8", 1}, {"i16", 2}, {"u16", 2}, {"i32", 4}, {"u32", 4}, {"f32", 4}, {"f64", 8}}};

const ComponentInfo& info(ComponentType type) { return kComponents[static_cast<std::size_t>(type)]; }

template <class T>
double component_of(const std::byte* place, bool normalized) {
  T value;
  std::memcpy(&value, place, sizeof value);
  const auto number = static_cast<double>(value);
  return normalized ? std::max(number / static_cast<double>(std::numeric_limits<T>::max()), -1.0) : number;
}

// Interpolates `count` components. Equal values stay as they are, infinite ones too.
template <class T>
void interpolate(const std::byte* from, const std::byte* to, double t, std::size_t count, std::byte* result) {
  for (std::size_t at = 0; at != count * sizeof(T); at += sizeof(T)) {
    T a;
    T b;
    std::memcpy(&a, from + at, sizeof a);
    std::memcpy(&b, to + at, sizeof b);
    if (a != b) {
      const double value = std::lerp(static_cast<double>(a), static_cast<double>(b), t);
      a = static_cast<T>(std::is_integral_v<T> ? std::round(value) : value);
    }
    std::memcpy(result + at, &a, sizeof a);
  }
}

// Copies old item old_of_new[i] to new item i; an item has `stride` values.
template <class T>
Buffer<T> gathered(const Buffer<T>& old, std::size_t stride, std::span<const std::uint32_t> old_of_new) {
  if (old.empty()) return {};
  constexpr std::size_t kGrain = 1 << 14;
  Buffer<T> values(old_of_new.size() * stride);
  for_each_range(old_of_new.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      std::copy_n(old.data() + old_of_new[i] * stride, stride, values.data() + i * stride);
    }
  });
  return values;
}

template <class T>
Buffer<T> copied(const Buffer<T>& values) {
  Buffer<T> copy(values.size());
  std::copy(values.begin(), values.end(), copy.begin());
  return copy;
}

}  // namespace

std::size_t component_size(ComponentType type) { return info(type).size; }
std::string_view component_name(ComponentType type) { return info(type).name; }

double component_value(const std::byte* place, ComponentType type, bool normalized) {
  switch (type) {
    case ComponentType::i8: return component_of<std::int8_t>(place, normalized);
    case ComponentType::u8: return component_of<std::uint8_t>(place, normalized);
    case ComponentType::i16: return component_of<std::int16_t>(place, normalized);
    case ComponentType::u16: return component_of<std::uint16_t>(place, normalized);
    case ComponentType::i32: return component_of<std::int32_t>(place, normalized);
    case ComponentType::u32: return component_of<std::uint32_t>(place, normalized);
    case ComponentType::f32: return component_of<float>(place, false);
    case ComponentType::f64: break;
  }
  return component_of<double>(place, false);
}

void set_interpolated(Attribute& attribute, std::size_t vertex, const Attribute& old, const EdgePoint& point) {
  const std::byte* const from = old.at(point.from).data();
  const std::byte* const to = old.at(point.to).data();
  std::byte* const result = attribute.values.data() + vertex * attribute.stride();
  const std::size_t count = attribute.components;
  const bool is_float = attribute.type == ComponentType::f32 || attribute.type == ComponentType::f64;
  if (!is_float && !attribute.normalized && attribute.role != AttributeRole::color) {
    std::copy_n(point.t > 0.5 ? to : from, attribute.stride(), result);
    return;
  }
  switch (attribute.type) {
    case ComponentType::i8: return interpolate<std::int8_t>(from, to, point.t, count, result);
    case ComponentType::u8: return interpolate<std::uint8_t>(from, to, point.t, count, result);
    case ComponentType::i16: return interpolate<std::int16_t>(from, to, point.t, count, result);
    case ComponentType::u16: return interpolate<std::uint16_t>(from, to, point.t, count, result);
    case ComponentType::i32: return interpolate<std::int32_t>(from, to, point.t, count, result);
    case ComponentType::u32: return interpolate<std::uint32_t>(from, to, point.t, count, result);
    case ComponentType::f32: return interpolate<float>(from, to, point.t, count, result);
    case ComponentType::f64: return interpolate<double>(from, to, point.t, count, result);
  }
}

glm::vec3 interpolated_normal(const Buffer<glm::vec3>& normals, const EdgePoint& point) {
  const glm::dvec3 normal = glm::mix(glm::dvec3(normals[point.from]), glm::dvec3(normals[point.to]), point.t);
  const double length = glm::length(normal);
  return length > 0 ? glm::vec3(normal / length) : normals[point.from];
}

std::size_t vertex_bytes(const Mesh& mesh) {
  std::size_t bytes = sizeof(glm::vec3) * (mesh.normals.empty() ? 1 : 2) + (mesh.edges.empty() ? 0 : sizeof(EdgeKey));
  for (const Attribute& attribute : mesh.attributes) bytes += attribute.stride();
  return bytes;
}

void gather_vertices(Mesh& mesh, std::span<const std::uint32_t> old_of_new) {
  auto positions = gathered(mesh.positions, 1, old_of_new);
  auto normals = gathered(mesh.normals, 1, old_of_new);
  auto edges = gathered(mesh.edges, 1, old_of_new);
  std::vector<Buffer<std::byte>> values;
  for (const Attribute& attribute : mesh.attributes) {
    values.push_back(gathered(attribute.values, attribute.stride(), old_of_new));
  }
  mesh.positions = std::move(positions);
  mesh.normals = std::move(normals);
  mesh.edges = std::move(edges);
  for (std::size_t a = 0; a < values.size(); ++a) mesh.attributes[a].values = std::move(values[a]);
}

Mesh copy(const Mesh& mesh) {
  Mesh result;
  result.name = mesh.name;
  result.origin = mesh.origin;
  result.material = mesh.material;
  result.positions = copied(mesh.positions);
  result.normals = copied(mesh.normals);
  result.edges = copied(mesh.edges);
  result.triangles = copied(mesh.triangles);
  for (const Attribute& a : mesh.attributes) {
    result.attributes.push_back(a.without_values());
    result.attributes.back().values = copied(a.values);
  }
  return result;
}

}  // namespace isoextract::mesh
