#pragma once

#include "extract/detail/net_points.hpp"
#include "extract/detail/voxel_chunks.hpp"
#include "extract/edge_geometry.hpp"

namespace isoextract::extract {

// Returns the mesh of a set of voxels. `base` is the sample index of voxel 0; `stats` holds the figures known so far.
// The mesh is closed, oriented and 2-manifold, except with VoxelFaces::rectangles. With a `net`, faces are not merged,
// and their corners are at the points of the net; null: at the voxel corners. Fails with ErrorCode::input if float32 or
// 32-bit indices cannot hold the mesh, with ErrorCode::out_of_memory or cancelled.
[[nodiscard]] Result<Extraction> mesh_voxels(const field::ScalarField& field, const VoxelChunks& voxels,
                                             const glm::ivec3& base, const OutputPlacement& placement,
                                             const ExtractOptions& options, const ExtractStats& stats,
                                             const Context& context, const NetPoints* net = nullptr);

}  // namespace isoextract::extract
