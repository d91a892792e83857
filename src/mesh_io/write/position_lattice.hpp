// Chooses the lattice for quantized positions and rounds vertices to it. See mesh_packing.hpp.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_packing.hpp"

namespace isoextract::mesh_io {

// Lattice point n, a vector of three whole numbers, is at (first + n) * step.
struct PositionLattice {
  double step = 1;
  glm::dvec3 first{0.0};  // whole numbers, in steps
  glm::uvec3 last{0};     // the largest n on each axis
  int bits = 1;           // bits of the largest component of `last`
  // The translation of the node, a multiple of the step: the first lattice point. Zero for float_world, and for
  // float_positions if float32 holds all lattice points exactly.
  glm::dvec3 origin{0.0};

  // Returns point n relative to the origin. Exact, since the point is at most 2^24 steps from the origin.
  [[nodiscard]] glm::vec3 local(const glm::uvec3& n) const { return local_first() + glm::vec3(glm::dvec3(n) * step); }
  [[nodiscard]] glm::vec3 local_first() const { return glm::vec3(first * step - origin); }
};

enum class LatticeUse {
  float_positions,  // float32 relative to the origin
  float_world,      // float32 without an origin
  short_positions   // 16-bit whole numbers counted from the origin
};

// Chooses a lattice that covers `box`.
[[nodiscard]] PositionLattice choose_lattice(const MeshPacking& packing, const mesh::Bounds& box, LatticeUse use);

struct LatticePositions {
  Buffer<glm::uvec3> numbers;  // the lattice point of each vertex
  PackedFacts::Positions facts;
  std::uint64_t flattened_triangles = 0;
};

// Rounds each vertex to the nearest lattice point. Fails with ErrorCode::output if a vertex is outside of the lattice.
[[nodiscard]] Result<LatticePositions> round_to_lattice(const mesh::Mesh& mesh, const PositionLattice& lattice);

}  // namespace isoextract::mesh_io
