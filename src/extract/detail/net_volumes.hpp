// Gives the shells of a relaxed surface net the volumes of their voxels.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "extract/detail/net_faces.hpp"
#include "extract/detail/net_grid.hpp"

namespace isoextract::extract {

// The largest relative error of a shell's volume that keep_volumes() accepts; limits of the cells can leave more.
inline constexpr double kNetVolumeTolerance = 0.0005;

// Moves points along the normals of their faces, within their cells, until each shell has the volume of its voxels.
// All faces of a shell move by the same distance; a face of two shells moves by the mean of their two moves. The first
// passes choose the distances of all shells together, so that neighbors do not undo each other's moves. The normals
// turn and cells limit moves, so further passes correct the shells whose volume is not right yet, until all volumes are
// right or a fixed number of passes has run. `offsets` and `output_from_index` are those of NetFaceSizes. Returns
// NetFaces::count_shells(). Runs in parallel; the result does not depend on the number of threads. Fails as
// NetFaces::make() does.
[[nodiscard]] Result<std::vector<LabelShells>> keep_volumes(const NetGrid& grid, const LabelChunks& labels,
                                                            const glm::dmat3& output_from_index,
                                                            NetArray<glm::vec3>& offsets, NetMemory& memory);

// Returns the bytes that keep_volumes() takes while it runs, without those of the shells.
[[nodiscard]] std::uint64_t volume_keeping_bytes(std::uint64_t points, std::uint64_t faces, std::uint64_t chunks);
// Returns the part of these bytes that is always in memory.
[[nodiscard]] std::uint64_t volume_list_bytes(std::uint64_t chunks);

}  // namespace isoextract::extract
