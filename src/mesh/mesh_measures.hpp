// All figures of a mesh in a report: its size, its connectivity and its components.
#pragma once

#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/component_facts.hpp"
#include "mesh/mesh.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"

namespace isoextract::mesh {

struct MeshMeasures {
  Topology topology;
  MeshSize size;
  Bounds bounds;
  std::vector<ComponentFacts> components;  // in the order of their first vertices
  Reservation memory;                      // for the components
};

// Measures a mesh in memory; partwise_measures.hpp measures one that comes in parts. The result does not depend on the
// number of threads. Fails with ErrorCode::out_of_memory.
[[nodiscard]] Result<MeshMeasures> measure_mesh(const Mesh& mesh, const Context& context);

}  // namespace isoextract::mesh
