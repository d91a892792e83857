// Finds the defects of a mesh that break slicers, game engines and solvers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "check/boundary_defects.hpp"
#include "check/mesh_requirement.hpp"
#include "check/normal_check.hpp"
#include "check/shells.hpp"
#include "mesh/mesh.hpp"
#include "mesh/metrics.hpp"
#include "mesh/self_intersections.hpp"
#include "mesh/topology.hpp"

namespace isoextract::check {

struct MeshCheck {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t repeated_vertices = 0;  // vertices with the coordinates of an earlier vertex
  mesh::Topology topology;
  // The topology after welding repeated_vertices; absent if the mesh has no repeated vertices or no open edges.
  std::optional<mesh::Topology> welded;
  mesh::MeshSize size;
  mesh::Bounds bounds;  // of the vertices that triangles use
  std::vector<BoundaryLoop> loops;
  std::vector<Component> components;
  mesh::SelfIntersections intersections;
  // Set by the caller from check_normals(), if the file has normals; check_mesh() leaves it empty.
  std::optional<NormalFigures> normals;
  Reservation memory;  // for loops and components

  // Returns whether the mesh encloses a volume: it has components, all have an inside, and no triangle repeats an
  // index.
  [[nodiscard]] bool has_volume() const;
  // Counts the components with this shell type.
  [[nodiscard]] std::uint64_t count(Shell shell) const;
};

// Checks a mesh with finite positions and valid indices; it may have no triangles. The result does not depend on the
// number of threads. Fails if the working memory exceeds the budget, or with ErrorCode::cancelled.
[[nodiscard]] Result<MeshCheck> check_mesh(const mesh::Mesh& mesh, const Context& context);

// Merges all vertices with equal coordinates into the first of them, which keeps its attributes. Fails if the working
// memory exceeds the budget; cannot be cancelled.
[[nodiscard]] Result<void> weld_coincident_vertices(mesh::Mesh& mesh, const Context& context);

// Returns why the mesh does not meet the requirement ("12 open edges in 2 loops"), or nothing if it does. A mesh
// without triangles meets none. `check` needs only the figures that the requirement is about; without
// MeshCheck::loops, the text names no loops.
[[nodiscard]] std::optional<std::string> unmet_reason(Requirement requirement, const MeshCheck& check);

}  // namespace isoextract::check
