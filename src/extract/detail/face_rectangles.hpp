// The exposed faces of voxels as rectangles, plane by plane.
//
// A plane's faces come row by row as runs, from whole words of bits: a run is what is inside and-not what is inside one
// step further. A rectangle begins with a run, or what is left of one, and goes on for as long as the next row has all
// of it: greedy meshing (Lysenko: Meshing in a Minecraft game. 2012) as a sweep, whose work grows with the runs and not
// with the plane.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "extract/detail/reserved_list.hpp"
#include "extract/detail/voxel_chunks.hpp"
#include "extract/voxel_faces.hpp"

namespace isoextract::extract {

// The two axes along the planes across `axis`, the lower one first.
[[nodiscard]] constexpr int plane_u(int axis) { return axis == 0 ? 1 : 0; }
[[nodiscard]] constexpr int plane_v(int axis) { return axis == 2 ? 1 : 2; }

// Faces of one plane, side by side. Corners are numbered like voxels: corner p is the lower one of voxel p.
struct FaceRectangle {
  std::int32_t plane = 0;  // along the axis
  std::int32_t low[2] = {0, 0};
  std::int32_t high[2] = {0, 0};  // along u and v, in corners
  bool upward = false;            // they look along the axis, not against it
};

// Those of a layer of chunks across one axis.
struct LayerRectangles {
  int axis = 0;
  ReservedList<FaceRectangle> rectangles;
};

// The exposed faces of all listed chunks, each once: axis by axis, each in rising layers. In parallel; the order is the
// same for any number of threads. Fails where there is no memory, and where the context is cancelled; `what` as in
// ReservedList, and it must outlive what is returned.
[[nodiscard]] Result<std::vector<LayerRectangles>> list_face_rectangles(const VoxelChunks& voxels, VoxelFaces faces,
                                                                        const Context& context,
                                                                        const std::string& what);

}  // namespace isoextract::extract
