// Exposed voxel faces as rectangles, plane by plane.
//
// The faces of a plane come row by row as runs of set bits: inside voxels whose neighbor across the plane is outside. A
// rectangle begins with a run, or the rest of a run, and continues while the next row covers its whole width. This is
// greedy meshing (Lysenko: Meshing in a Minecraft game. 2012) as a sweep. The work grows with the number of runs, not
// with the size of the plane.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "extract/detail/reserved_list.hpp"
#include "extract/detail/voxel_chunks.hpp"
#include "extract/voxel_faces.hpp"

namespace isoextract::extract {

// Returns the lower one of the two axes that span the planes perpendicular to `axis`.
[[nodiscard]] constexpr int plane_u(int axis) { return axis == 0 ? 1 : 0; }
// Returns the higher one of these two axes.
[[nodiscard]] constexpr int plane_v(int axis) { return axis == 2 ? 1 : 2; }

// A rectangle of adjacent faces in one plane. Positions are grid corners: corner p is the lower corner of voxel p.
struct FaceRectangle {
  std::int32_t plane = 0;         // position along the axis
  std::int32_t low[2] = {0, 0};   // along plane_u() and plane_v()
  std::int32_t high[2] = {0, 0};  // as `low`; the corner after the last face
  bool upward = false;            // the faces point along the axis, not against it
};

// The rectangles of a layer of chunks across one axis.
struct LayerRectangles {
  int axis = 0;
  ReservedList<FaceRectangle> rectangles;
};

// Returns the exposed faces of all listed chunks, each once: axis by axis, in rising layers. Runs in parallel; the
// order does not depend on the number of threads. Fails if memory runs out and if the context is cancelled. `what`
// starts the message (ReservedList) and must outlive the result.
[[nodiscard]] Result<std::vector<LayerRectangles>> list_face_rectangles(const VoxelChunks& voxels, VoxelFaces faces,
                                                                        const Context& context,
                                                                        const std::string& what);

}  // namespace isoextract::extract
