// Bounds how far an edit moved the surface of a mesh.
#pragma once

#include <span>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// Returns an upper bound of the Hausdorff distance between the mesh and its old state, in the space of `to_metric`; 0
// if nothing changed. Measures only changed triangles, and only to triangles that have a vertex in common with changed
// ones. The mesh may have new vertices and triangles after the old ones. Fails with ErrorCode::out_of_memory or
// ErrorCode::cancelled. Throws std::bad_alloc.
[[nodiscard]] Result<double> bound_surface_change(std::span<const glm::vec3> old_positions,
                                                  std::span<const glm::uvec3> old_triangles, const mesh::Mesh& mesh,
                                                  const glm::dmat3& to_metric, const Context& context);

}  // namespace isoextract::edit
