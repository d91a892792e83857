// The mesh of a set of voxels.
#pragma once

#include "extract/detail/net_points.hpp"
#include "extract/detail/voxel_chunks.hpp"
#include "extract/edge_geometry.hpp"

namespace isoextract::extract {

// `base` is the sample that voxel 0 is; `stats` is what is known already. The mesh is closed, oriented and 2-manifold,
// unless options.voxel_faces says otherwise. `net`: its faces are not merged, and their corners are where the net has
// them; null: where the voxels have them. Fails as Extractor::extract() does.
[[nodiscard]] Result<Extraction> mesh_voxels(const field::ScalarField& field, const VoxelChunks& voxels,
                                             const glm::ivec3& base, const OutputFrame& placement,
                                             const ExtractOptions& options, const ExtractStats& stats,
                                             const Context& context, const NetPoints* net = nullptr);

}  // namespace isoextract::extract
