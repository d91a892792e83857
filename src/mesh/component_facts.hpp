// Sizes and connectivity of each component of a mesh.
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
  double volume = 0;  // enclosed, negative for the wall of a cavity; it means something for closed ones only
  Bounds bounds;      // with the mesh's origin
  Topology topology;

  [[nodiscard]] bool is_closed() const { return topology.is_closed_oriented_manifold(); }
  // Its triangles face into a space that it closes off: the wall of a cavity.
  [[nodiscard]] bool is_cavity() const { return is_closed() && volume < 0; }
};

// Of each component, in their order; areas and volumes in the space that `to_metric` leads to. A triangle that repeats
// an index is of none. The same for any number of threads. The list is the
// caller's to reserve; fails where the memory for the work is not there.
[[nodiscard]] Result<std::vector<ComponentFacts>> measure_components(const Mesh& mesh, const Components& components,
                                                                     const glm::dmat3& to_metric,
                                                                     const Context& context);

}  // namespace isoextract::mesh
