// What can be wrong with a mesh for those who use it next: slicers, engines, solvers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "check/mesh_borders.hpp"
#include "check/mesh_requirement.hpp"
#include "check/normal_check.hpp"
#include "check/self_intersections.hpp"
#include "check/shells.hpp"
#include "mesh/mesh.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"

namespace isoextract::check {

struct MeshCheck {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t repeated_vertices = 0;  // where an earlier vertex lies, exactly
  mesh::Topology topology;
  // Were those vertices one with the earlier ones; where there are any, and open edges.
  std::optional<mesh::Topology> joined;
  mesh::MeshSize size;
  mesh::Bounds bounds;
  std::vector<BorderLoop> loops;
  std::vector<Component> components;
  SelfIntersections intersections;
  std::optional<NormalFacts> normals;  // of a file that has normals
  Reservation memory;                  // for loops and components

  [[nodiscard]] std::uint64_t count(Shell shell) const;  // components
};

// Positions are finite, and indices of vertices that are there. A mesh without triangles is none that cannot be
// checked. The same for any number of threads. Fails where its working memory is more than is left, and with
// ErrorCode::cancelled.
[[nodiscard]] Result<MeshCheck> check_mesh(const mesh::Mesh& mesh, const Context& context);

// Makes one vertex of all that have the same coordinates: the first of them, whose attributes stay. Fails as
// check_mesh() does.
[[nodiscard]] Result<void> join_repeated_vertices(mesh::Mesh& mesh, const Context& context);

// Why the mesh does not meet it, as "12 open edges in 2 loops"; nothing where it does. A mesh without triangles meets
// none.
[[nodiscard]] std::optional<std::string> why_not(Requirement requirement, const MeshCheck& check);

}  // namespace isoextract::check
