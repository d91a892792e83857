// The planes that caps of a mesh may lie in, besides the data boundary and the faces of a region.
#pragma once

#include <span>

#include "mesh/half_space.hpp"

namespace isoextract::accuracy {

struct CapPlanes {
  std::span<const mesh::HalfSpace> cuts = {};  // capped clip planes: triangles in them are caps, too
  // In voxels: how far caps may have moved from their planes since. Moved triangles count as caps only if they still
  // face along the plane's normal.
  double moved = 0;
};

}  // namespace isoextract::accuracy
