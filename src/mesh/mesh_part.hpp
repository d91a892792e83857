// Copies a part of a mesh.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

// Ranges of vertices and of triangles. The triangles use no other vertices.
struct PartRange {
  std::uint64_t first_vertex = 0;
  std::uint64_t vertices = 0;
  std::uint64_t first_triangle = 0;
  std::uint64_t triangles = 0;
};

enum class PartData { positions, attributes };

// Returns a mesh of these vertices and triangles with the name and origin of `mesh`, and with PartData::attributes also
// its attributes. Normals, edge keys and material are left out. Fails with ErrorCode::out_of_memory. Throws
// std::bad_alloc.
[[nodiscard]] Result<Mesh> copy_part(const Mesh& mesh, const PartRange& part, PartData data, const Context& context);

}  // namespace isoextract::mesh
