// Makes the inner wall of a hollow body: the surface inside a closed mesh at a fixed distance from it.
//
// The distance to the mesh is exact: it is measured to the closest point of all triangles. A grid of cubic cells covers
// the points near the inner wall, and marching cubes finds where the distance crosses the thickness. Each vertex then
// moves along its grid edge to the point at this distance, but stays 0.001 of a cell away from the ends of the edge.
// Between vertices the distance differs: for a point p of a triangle whose corners have the distance T, in a cell of
// side c, sqrt(T^2 - c^2) <= distance(p) <= T + c. Lower bound: let q be the point of the mesh closest to p, and M(x)
// the mean of the corners' squared distances from x, weighted by the barycentric coordinates of p. Then
// |p - q|^2 = M(q) - M(p), M(q) >= T^2 and M(p) <= c^2. Upper bound: a corner is at most c away from p. Parts of the
// cavity that are thinner than a cell may be left out.
#pragma once

#include <cstdint>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::extract {

struct WallOptions {
  double thickness = 1;  // in the mesh's units, above 0
  double cell = 0.25;    // side of the grid's cells; below `thickness`
};

struct WallFigures {
  std::uint64_t cavities = 0;  // components of the inner wall that face inward: each bounds one new empty space
  // Components that face outward: each is the outside of a wall around a cavity of the mesh. The wall lies loose in the
  // new empty space.
  std::uint64_t loose_walls = 0;
  // The least and the greatest distance from the inner wall to the mesh, measured at the centers and edge midpoints of
  // the wall's triangles; 0 if the wall is empty.
  double thinnest = 0;
  double thickest = 0;
  double rms_difference = 0;  // of these distances from the thickness
};

struct InnerWall {
  mesh::Mesh mesh;                         // empty if no part is thick enough; has normals if the given mesh has
  Buffer<std::uint32_t> nearest_vertices;  // for each vertex, the closest corner of the given mesh's closest triangle
  WallFigures figures;
};

// Returns the inner wall of the closed, oriented mesh `outer`, with the mesh origin of `outer`. The wall follows all
// shells of `outer`, also those around cavities. The triangles of the wall face the new empty space. The wall is a
// closed oriented manifold and lies in the material, where the winding number of `outer` is above 0. The result does
// not depend on the number of threads. Fails with ErrorCode::input if the grid would have more than 2^24 cells along an
// axis, with ErrorCode::out_of_memory or ErrorCode::cancelled. Throws std::bad_alloc.
[[nodiscard]] Result<InnerWall> make_inner_wall(const mesh::Mesh& outer, const WallOptions& options,
                                                const Context& context);

// Returns an estimate of the memory that make_inner_wall() takes for a surface of this area and number of triangles.
[[nodiscard]] std::uint64_t estimated_wall_bytes(std::uint64_t triangles, double area, double cell);

}  // namespace isoextract::extract
