// Reads the normals of glTF primitives.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include <nlohmann/json.hpp>

#include "mesh_io/read/gltf_data.hpp"
#include "mesh_io/read/gltf_json.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {

// Maps a triangle's number within its primitive to its three vertices, also numbered within the primitive.
using PrimitiveCorners = std::function<std::array<std::uint64_t, 3>(std::uint64_t)>;

// Appends the normals of a primitive, and for each triangle the indices of its corners' normals. Turns the normals as
// `transform` turns the surface, and keeps their lengths. A primitive without normals gets FileNormals::kNone for every
// corner. Throws DamagedMesh.
void add_gltf_normals(GltfData& data, const nlohmann::json& attributes, std::uint64_t vertices, std::uint64_t triangles,
                      const PrimitiveCorners& corners, const Transform& transform, MemoryUse& memory,
                      FileSurfaceNormals& normals);

}  // namespace isoextract::mesh_io
