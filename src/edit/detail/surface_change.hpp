// Bounds how far an edit moved the surface of a mesh.
#pragma once

#include <span>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// Returns an upper bound of the Hausdorff distance between the mesh and what it was before, in the space of
// `to_metric`; 0 if nothing changed. Measures the triangles that changed, to those near them. The mesh may have more
// vertices and triangles than before, at the end. Fails with ErrorCode::out_of_memory or ErrorCode::cancelled. Throws
// std::bad_alloc.
[[nodiscard]] Result<double> bound_surface_change(std::span<const glm::vec3> old_positions,
                                                  std::span<const glm::uvec3> old_triangles, const mesh::Mesh& mesh,
                                                  const glm::dmat3& to_metric, const Context& context);

}  // namespace isoextract::edit
