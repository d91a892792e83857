// Size and connectivity of each component of a mesh.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/components.hpp"
#include "mesh/mesh.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"

namespace isoextract::mesh {

struct ComponentFacts {
  std::uint64_t triangles = 0;
  double area = 0;
  double volume = 0;  // enclosed; negative for the shell of a cavity; meaningful for closed components only
  Bounds bounds;      // including the mesh's origin
  Topology topology;

  [[nodiscard]] bool is_closed() const { return topology.is_closed_oriented_manifold(); }
  // Returns whether the triangles face the space that the component encloses, as those of a cavity do.
  [[nodiscard]] bool faces_inward() const { return is_closed() && volume < 0; }
};

// Returns the facts of each component in order, with areas and volumes in the space that `to_metric` maps to. Triangles
// that repeat an index belong to no component. The result is the same for any number of threads. The caller reserves
// memory for the list. Fails with ErrorCode::out_of_memory.
[[nodiscard]] Result<std::vector<ComponentFacts>> measure_components(const Mesh& mesh, const Components& components,
                                                                     const glm::dmat3& to_metric,
                                                                     const Context& context);

}  // namespace isoextract::mesh
