// Counts the components of a mesh and their Euler numbers.
#pragma once

#include <algorithm>
#include <map>

#include "mesh/mesh.hpp"
#include "support/trilinear_topology.hpp"

namespace isoextract::test {

// Returns the sorted Euler numbers, vertices - edges + triangles, of the components of a closed mesh, which has 3/2
// edges per triangle.
[[nodiscard]] inline SurfaceTopology component_euler_numbers(const mesh::Mesh& mesh) {
  DisjointSets components;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) components.add();
  for (const glm::uvec3& t : mesh.triangles) {
    components.join(t.x, t.y);
    components.join(t.x, t.z);
  }
  std::map<std::size_t, int> twice;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) twice[components.find(v)] += 2;
  for (const glm::uvec3& t : mesh.triangles) twice[components.find(t.x)] -= 1;
  SurfaceTopology topology;
  for (const auto& [component, number] : twice) topology.push_back(number / 2);
  std::sort(topology.begin(), topology.end());
  return topology;
}

}  // namespace isoextract::test
