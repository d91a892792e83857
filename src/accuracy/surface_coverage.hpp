// What a mesh has lost of the isosurface of its data, and how far that is from the mesh. A mesh may be near to the
// isosurface everywhere and lack half of it: the distances from the mesh say nothing of a part that has no triangle.
//
// A component of the isosurface counts as lost where no vertex of the mesh is nearer to it than to every other
// component: that needs no distance to be chosen, and a small component beside a large one is not taken for there
// because the large one is near.
#pragma once

#include <cstdint>
#include <span>

#include "accuracy/error_statistics.hpp"
#include "base/context.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::accuracy {

struct SurfaceCoverage {
  ErrorStatistics distances;     // from points on the isosurface to the mesh, by area; without points where it has none
  Length max_at_most;            // no point of the isosurface is farther: distances.max is that of points alone
  std::uint64_t components = 0;  // of the isosurface
  std::uint64_t lost = 0;        // of these
};

// Sets the counts. `surface` is the isosurface in whole cells, and `tree` is made of it where it has triangles. Of a
// mesh that was cut, `clipped` says what was kept, and nothing else counts. Takes coverage_bytes(), the caller's to
// reserve.
void count_components(const mesh::Mesh& mesh, const mesh::Mesh& surface, const mesh::TriangleTree* tree,
                      std::span<const mesh::HalfSpace> clipped, const Context& context, SurfaceCoverage& coverage);

[[nodiscard]] std::uint64_t coverage_bytes(std::uint64_t vertices, std::uint64_t triangles);

// Whether a point of the mesh's coordinates is in what was kept.
[[nodiscard]] bool is_kept(const glm::dvec3& p, std::span<const mesh::HalfSpace> clipped);

}  // namespace isoextract::accuracy
