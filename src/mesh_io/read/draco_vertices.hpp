// Decodes Draco data for the mesh readers.
#pragma once

#include <span>

#include "mesh_io/detail/draco_codec.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {

// Decodes the bytes and counts their memory in `memory`. Throws DamagedMesh and Cancelled.
[[nodiscard]] DracoSurface unpack_draco_surface(std::span<const std::byte> bytes, MemoryUse& memory);

// Sorts the vertices in the order of the corners and returns true, if every vertex belongs to exactly one triangle
// corner. Otherwise changes nothing and returns false.
bool order_as_corners(DracoSurface& surface, MemoryUse& memory);

}  // namespace isoextract::mesh_io
