// The planes that caps of a mesh may lie in, besides the data boundary and the faces of a region.
#pragma once

#include <span>

#include "mesh/half_space.hpp"

namespace isoextract::accuracy {

struct CapPlanes {
  std::span<const mesh::HalfSpace> cuts = {};  // capped clip planes: triangles in them are caps, too
  // How far edits may have moved caps from their planes, in voxels. If above 0, triangles count as caps only if their
  // normal is within 25 degrees of the plane's normal or its opposite.
  double moved = 0;
};

}  // namespace isoextract::accuracy
