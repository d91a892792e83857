// What Draco unpacked, for the readers.
#pragma once

#include <span>

#include "mesh_io/detail/draco_codec.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {

// Throws DamagedMesh and Cancelled.
[[nodiscard]] DracoSurface unpack_draco_surface(std::span<const std::byte> bytes, MemoryUse& memory);

// Where no two triangles share a vertex and none is left over, puts the vertices into the order of the triangles'
// corners and returns true.
bool order_as_corners(DracoSurface& surface, MemoryUse& memory);

}  // namespace isoextract::mesh_io
