// The lattice that quantised positions lie on: which one, and where on it a vertex is. See mesh_packing.hpp.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_packing.hpp"

namespace isoextract::mesh_io {

// The lattice point with number n is (first + n) * step, on every axis.
struct PositionLattice {
  double step = 1;
  glm::dvec3 first{0.0};  // whole numbers
  glm::uvec3 last{0};     // the greatest n
  int bits = 1;           // of the greatest of them
  // Of the node; a multiple of the step. Zero where float32 holds the lattice's points, or where a format has no nodes.
  glm::dvec3 origin{0.0};

  // Relative to the origin, exactly: less than 2^24 steps.
  [[nodiscard]] glm::vec3 local(const glm::uvec3& n) const { return local_first() + glm::vec3(glm::dvec3(n) * step); }
  [[nodiscard]] glm::vec3 local_first() const { return glm::vec3(first * step - origin); }
};

enum class LatticeUse {
  float_positions,  // float32 relative to the origin
  float_world,      // float32 without an origin
  short_positions   // whole numbers of 16 bits from the origin on
};

// For vertices in `box`.
[[nodiscard]] PositionLattice choose_lattice(const MeshPacking& packing, const mesh::Bounds& box, LatticeUse use);

struct LatticePositions {
  Buffer<glm::uvec3> numbers;  // one a vertex
  PackedFacts::Positions facts;
  std::uint64_t flattened_triangles = 0;
};

// Fails with ErrorCode::output where a vertex is outside of the lattice.
[[nodiscard]] Result<LatticePositions> put_on_lattice(const mesh::Mesh& mesh, const PositionLattice& lattice);

}  // namespace isoextract::mesh_io
