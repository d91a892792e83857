// What Draco unpacked, for the readers.
#pragma once

#include <span>

#include "meshes/detail/draco_codec.hpp"
#include "meshes/read/mesh_format_readers.hpp"

namespace isoextract::meshes {

// Throws DamagedMesh and Cancelled.
[[nodiscard]] DracoSurface unpack_draco_surface(std::span<const std::byte> bytes, MemoryUse& memory);

// Where no two triangles share a vertex and none is left over, puts the vertices into the order of the triangles'
// corners and returns true.
bool order_as_corners(DracoSurface& surface, MemoryUse& memory);

}  // namespace isoextract::meshes
