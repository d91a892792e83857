// Draco's bit streams: surfaces into bytes and back. The one file that includes the library is draco_codec.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "mesh/attributes.hpp"

namespace isoextract::mesh_io {

enum class DracoMethod {
  edgebreaker,  // along the surface: small, in an order of its own; what is no manifold is cut up
  sequential    // one triangle after the other, as they are
};

inline constexpr int kDracoNormalBits = 10;

struct DracoInput {
  // Of the vertices, in steps from `first`; below 2^bits.
  std::span<const glm::uvec3> positions;
  glm::vec3 first{0.0F};  // a whole number of steps, as is every sum with a position, exactly
  float step = 1;         // a power of two
  int bits = 1;
  std::span<const glm::uvec3> triangles;
  std::span<const glm::vec3> normals;  // of the vertices or, with `face_normals`, of the triangles; or empty
  bool face_normals = false;           // vertices are split where triangles meet
  std::vector<const mesh::Attribute*> attributes;  // of the vertices; integers of at most 16 bits, or f32
  std::vector<std::string> names;                  // of the attributes
  bool names_in_file = false;
  std::string generator;  // in the file as well, unless empty
  std::string placement;  // likewise
};

// Ids of the attributes in the bytes: positions, normals if any, attributes.
inline constexpr std::uint32_t kDracoPositions = 0;
[[nodiscard]] constexpr std::uint32_t draco_attribute_id(bool normals, std::size_t attribute) {
  return static_cast<std::uint32_t>((normals ? 2 : 1) + attribute);
}

// Fails with ErrorCode::output where the library does. Throws std::bad_alloc.
[[nodiscard]] Result<std::vector<std::byte>> encode_draco(const DracoInput& input, DracoMethod method);

struct DracoAttribute {
  std::uint32_t id = 0;
  bool is_position = false;
  bool is_normal = false;
  bool is_colour = false;
  std::string name;  // empty if the file has none
  mesh::ComponentType type = mesh::ComponentType::f32;
  std::size_t components = 0;
  bool normalised = false;
  std::vector<std::byte> values;  // one a vertex, without gaps
};

struct DracoSurface {
  std::uint64_t vertices = 0;
  std::vector<glm::uvec3> triangles;
  std::vector<DracoAttribute> attributes;
  std::string generator;
  std::string placement;

  [[nodiscard]] const DracoAttribute* find(std::uint64_t id) const;
  [[nodiscard]] DracoAttribute* find(std::uint64_t id);
};

[[nodiscard]] bool is_draco(std::span<const std::byte> bytes);

// Asked for before memory is taken; throws what shall come of too much.
using TakeMemory = std::function<void(std::uint64_t bytes)>;

// Of bytes that may be anything. Fails with ErrorCode::input and a message without a file's name; throws what `take`
// throws, and std::bad_alloc. Indices of triangles are below `vertices`.
[[nodiscard]] Result<DracoSurface> decode_draco(std::span<const std::byte> bytes, const TakeMemory& take);

}  // namespace isoextract::mesh_io
