// Triangles cut at planes: of a mesh what lies in half-spaces is kept, exactly. This is the clipping of polygons by
// Sutherland and Hodgman (Reentrant polygon clipping, Comm. ACM 17(1), 1974), triangle by triangle; triangles that
// share an edge share the vertex that it is cut at.
#pragma once

#include <cstdint>
#include <span>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct ClipFacts {
  std::uint64_t triangles_before = 0;
  std::uint64_t triangles_cut = 0;  // that a plane goes through
  std::uint64_t triangles_after = 0;
};

// Keeps of `mesh`, which has no attributes yet, what lies in all of `kept`, given in its own coordinates. Vertices that
// are nearer to a plane than a few roundings of a float32 position count as on it and stay where they are; all that is
// left is within that of the half-spaces. Old vertices stay in their order, new ones follow; triangles stay in their
// order and wind as before, and normals of new vertices are those between. The mesh is open where it was cut. Nothing
// changes where nothing is outside. The same for any number of threads. Memory is reserved; fails where it is not
// there.
[[nodiscard]] Result<ClipFacts> clip_to_half_spaces(mesh::Mesh& mesh, std::span<const mesh::HalfSpace> kept,
                                                    const Context& context = Context());

}  // namespace isoextract::edit
