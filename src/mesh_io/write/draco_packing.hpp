// A mesh as Draco's bytes, unpacked again and compared before they are taken for good.
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
  PositionLattice lattice;  // of float_positions or float_world
  bool flat_normals = false;
  std::vector<GltfSemantic> semantics;
  bool is_file = false;   // it says itself what attributes are called, and who wrote it
  std::string placement;  // in such a file, as MeshWriteOptions has it
};

struct DracoPacked {
  std::vector<std::byte> bytes;
  std::uint64_t vertices = 0;  // that unpacking gives; with flat normals three a triangle
  bool has_normals = false;
  mesh::LocalBounds bounds;  // of the unpacked positions, relative to the lattice's origin
  PackedFacts facts;         // without bytes_before
};

// Fails with ErrorCode::output where a vertex is outside of the lattice, where the memory is not there, and where what
// was unpacked is not the mesh.
[[nodiscard]] Result<DracoPacked> pack_with_draco(const mesh::Mesh& mesh, const DracoPacking& packing,
                                                  const Context& context);

}  // namespace isoextract::mesh_io
