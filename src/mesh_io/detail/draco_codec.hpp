// Encodes surfaces as Draco bit streams and decodes them. Only draco_codec.cpp includes the Draco library.
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
  edgebreaker,  // walks along the surface: small output in another order; splits non-manifold meshes
  sequential    // stores triangle after triangle in their order
};

inline constexpr int kDracoNormalBits = 10;

struct DracoInput {
  // One per vertex: offset from `first` in steps, below 2^bits.
  std::span<const glm::uvec3> positions;
  glm::vec3 first{0.0F};  // an exact multiple of the step, as is its sum with every position
  float step = 1;         // a power of two
  int bits = 1;
  std::span<const glm::uvec3> triangles;
  std::span<const glm::vec3> normals;              // one per vertex or, with `face_normals`, per triangle; may be empty
  bool face_normals = false;                       // splits vertices: each triangle gets its own three
  std::vector<const mesh::Attribute*> attributes;  // vertex attributes: integers of up to 16 bits, or f32
  std::vector<std::string> names;                  // one per attribute
  bool names_in_file = false;
  std::string generator;  // stored in the file unless empty
  std::string placement;  // stored in the file unless empty
};

// Attribute ids in the bit stream: positions are 0, normals (if any) 1, the vertex attributes follow.
inline constexpr std::uint32_t kDracoPositions = 0;
[[nodiscard]] constexpr std::uint32_t draco_attribute_id(bool normals, std::size_t attribute) {
  return static_cast<std::uint32_t>((normals ? 2 : 1) + attribute);
}

// Returns the Draco bytes of the surface. Fails with ErrorCode::output if the library does. Throws std::bad_alloc.
[[nodiscard]] Result<std::vector<std::byte>> encode_draco(const DracoInput& input, DracoMethod method);

struct DracoAttribute {
  std::uint32_t id = 0;
  bool is_position = false;
  bool is_normal = false;
  bool is_color = false;
  std::string name;  // empty if the file has none
  mesh::ComponentType type = mesh::ComponentType::f32;
  std::size_t components = 0;
  bool normalized = false;
  std::vector<std::byte> values;  // one value per vertex, without padding
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

// Called with the size before memory is allocated; throws to refuse it.
using TakeMemory = std::function<void(std::uint64_t bytes)>;

// Decodes untrusted bytes. Fails with ErrorCode::input and a message without the file's name. Passes on exceptions of
// `take`, and throws std::bad_alloc. Every index in `triangles` is below `vertices`.
[[nodiscard]] Result<DracoSurface> decode_draco(std::span<const std::byte> bytes, const TakeMemory& take);

}  // namespace isoextract::mesh_io
