// Where a mesh may have caps besides those in the data boundary or a region's faces.
#pragma once

#include <span>

#include "mesh/half_space.hpp"

namespace isoextract::accuracy {

struct CapPlaces {
  std::span<const mesh::HalfSpace> cuts = {};  // that are capped: triangles in their planes are caps, too
  double moved = 0;  // voxels: how far caps may be from their planes since; such triangles face as these do
};

}  // namespace isoextract::accuracy
