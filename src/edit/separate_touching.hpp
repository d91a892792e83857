// Moves apart vertices that are at equal positions, where sheets of a surface touch at an edge or vertex.
//
// Surface nets and voxels give each sheet its own vertices there, so the mesh is a 2-manifold by its indices. Programs
// that weld vertices by position (all readers of STL) join the sheets again and find non-manifold edges and vertices.
//
// The triangles around a vertex form a cone. The other sheets that touch the vertex lie on one side of this cone. The
// vertex moves to the other side, in a direction that lies on that side of all triangles of the cone. So the moved
// triangles lie on the side of the old ones that faces away from the other sheets, and cannot meet these. The cone of a
// vertex may be so bent that it has no such direction, or it may have sheets on both sides: this vertex stays, and the
// other vertices at the position move away.
// If two or more cones at one position have no such direction, each of their vertices moves off only those triangles of
// its cone that share an edge with another cone there. If some have no such direction either, all of these but one move
// along the means of their normals; triangles may then intersect within the distance.
// Directions are found in voxel coordinates, where the sheets are not stretched.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct SeparationFigures {
  std::uint64_t touching = 0;  // vertices at the position of another vertex, before
  std::uint64_t moved = 0;
  double greatest_move = 0;  // in the mesh's units
  double volume_before = 0;  // mesh::MeshSize::volume; 0 if no vertices touch
  double volume_after = 0;
};

// Moves the touching vertices that have a direction (see above) by the distance `voxels`, in voxels, if float32 is fine
// enough there. Else moves them by eight float32 steps at their world position, or not at all if eight steps exceed 20
// times the distance. The columns of `voxel` are the edges of a voxel in the mesh's units; if they have no volume, a
// voxel is a cube as large as the unit. Triangles, attributes and the order of vertices stay. Positions must be finite.
// The result does not depend on the number of threads. Fails with ErrorCode::out_of_memory or cancelled.
[[nodiscard]] Result<SeparationFigures> separate_touching_vertices(mesh::Mesh& mesh, double voxels,
                                                                   const glm::dmat3& voxel, const Context& context);

}  // namespace isoextract::edit
