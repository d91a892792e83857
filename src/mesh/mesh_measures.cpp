#include "mesh/mesh_measures.hpp"

#include <new>
#include <string>

#include "base/allocation_error.hpp"
#include "mesh/components.hpp"

namespace isoextract::mesh {
namespace {

Result<void> measure_components(const Mesh& mesh, const std::string& what, const Context& context,
                                MeshMeasures& measures) {
  const auto labels = TRY(context.reserve(Components::bytes(mesh.positions.size()), what));
  const Components components(mesh.triangles.span(), mesh.positions.size());
  measures.memory = TRY(context.reserve(components.count() * sizeof(ComponentFacts), what));
  measures.components = TRY(measure_components(mesh, components, glm::dmat3(1.0), context));
  return {};
}

}  // namespace

Result<MeshMeasures> measure_mesh(const Mesh& mesh, const Context& context) {
  MeshMeasures measures;
  measures.topology = TRY(measure_topology(mesh, context));
  const std::string what = mesh.name + ": the components of its surface";
  try {
    TRY(measure_components(mesh, what, context, measures));
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
  measures.size = measure_size(mesh);
  measures.bounds = measure_bounds(mesh);
  return measures;
}

}  // namespace isoextract::mesh
