// The normals of a glTF file's primitives.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include <nlohmann/json.hpp>

#include "mesh_io/read/gltf_data.hpp"
#include "mesh_io/read/gltf_json.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {

// Which vertices of its primitive a triangle has, by the triangle's number in the primitive.
using PrimitiveCorners = std::function<std::array<std::uint64_t, 3>(std::uint64_t)>;

// Appends the normals of a primitive of `vertices` vertices, as `transform` turns them, and the numbers of those that
// the `triangles` triangles have; none where the primitive has no normals. Throws DamagedMesh.
void add_gltf_normals(GltfData& data, const nlohmann::json& attributes, std::uint64_t vertices, std::uint64_t triangles,
                      const PrimitiveCorners& corners, const Transform& transform, MemoryUse& memory,
                      FileSurfaceNormals& normals);

}  // namespace isoextract::mesh_io
