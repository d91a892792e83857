// Measures which parts of the isosurface a mesh lacks, and how far the isosurface is from the mesh. A mesh may be close
// to the isosurface everywhere and still lack half of it: distances from the mesh do not show a part without triangles.
//
// A component of the isosurface counts as lost if no vertex of the mesh is nearer to it than to all other components.
// This needs no distance limit, and a small component does not count as found just because a large one is near.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "accuracy/error_statistics.hpp"
#include "mesh/half_space.hpp"

namespace isoextract::accuracy {

struct SurfaceCoverage {
  // From points on the isosurface to the mesh, weighted by area; no points if the isosurface or the mesh is empty.
  ErrorStatistics distances;
  // Estimated upper bound of the distance from any isosurface point to the mesh. It is the true bound for the small
  // triangles that approximate the isosurface, plus an estimate of how far the isosurface bulges out of them.
  // distances.max is the largest distance of the measured points only.
  Length max_at_most;
  std::uint64_t components = 0;  // components of the isosurface
  std::uint64_t lost = 0;        // components that the mesh lacks
};

// Returns whether a point in the mesh's coordinates is inside or on the boundary of all half-spaces in which a clipped
// mesh lies.
[[nodiscard]] inline bool is_kept(const glm::dvec3& p, std::span<const mesh::HalfSpace> kept) {
  return std::ranges::all_of(kept, [&](const mesh::HalfSpace& side) { return side.depth(p) >= 0; });
}

}  // namespace isoextract::accuracy
