// Packs a mesh with Draco, unpacks it again and compares the result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"
#include "mesh/metrics.hpp"
#include "mesh_io/mesh_packing.hpp"
#include "mesh_io/write/gltf_part.hpp"
#include "mesh_io/write/position_lattice.hpp"

namespace isoextract::mesh_io {

struct DracoPacking {
  PositionLattice lattice;  // for LatticeUse::float_positions or float_world
  bool flat_normals = false;
  std::vector<GltfSemantic> semantics;
  bool is_file = false;   // a .drc file: stores attribute names and the generator
  std::string placement;  // MeshWriteOptions::placement, for a .drc file
};

struct DracoPacked {
  std::vector<std::byte> bytes;
  std::uint64_t vertices = 0;  // after unpacking; with flat normals three per triangle
  bool has_normals = false;
  mesh::LocalBounds bounds;  // of the unpacked positions, relative to the lattice's origin
  PackedFacts facts;         // without bytes_before
};

// Packs with edgebreaker, or with the sequential method if edgebreaker does not reproduce the mesh. Fails with
// ErrorCode::output if a vertex lies outside of the lattice or unpacking does not reproduce the mesh, and as
// Context::reserve() does.
[[nodiscard]] Result<DracoPacked> pack_with_draco(const mesh::Mesh& mesh, const DracoPacking& packing,
                                                  const Context& context);

}  // namespace isoextract::mesh_io
