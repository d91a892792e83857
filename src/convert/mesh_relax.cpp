#include "convert/mesh_relax.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "base/reserved_buffer.hpp"
#include "mesh/components.hpp"

namespace isoextract::convert {
namespace {

Json json_of(const RelaxedVolume& volume) { return {{"before", volume.before}, {"after", volume.after}}; }

// Of the tetrahedron from the apex to a triangle. The apex is a vertex of the component, so that little cancels.
double volume_to(std::span<const glm::vec3> positions, const glm::uvec3& triangle, const glm::dvec3& apex) {
  const glm::dvec3 a = glm::dvec3(positions[triangle.x]) - apex;
  const glm::dvec3 b = glm::dvec3(positions[triangle.y]) - apex;
  const glm::dvec3 c = glm::dvec3(positions[triangle.z]) - apex;
  return glm::dot(a, glm::cross(b, c)) / 6;
}

struct Component {
  std::uint32_t apex = mesh::Components::kNone;
  RelaxedVolume volume;
};

}  // namespace

Json json_of(const RelaxRecord& record) {
  return {{"iso", record.iso},
          {"volume", json_of(record.whole)},
          {"components", record.components},
          {"changed_components", record.changed_components},
          {"worst_component", record.components > 0 ? json_of(record.worst_component) : Json(nullptr)}};
}

Result<RelaxRecord> relax_record(const mesh::Mesh& mesh, double iso, std::string surface, const edit::Sites& sites,
                                 const Context& context) {
  RelaxRecord record;
  record.iso = iso;
  record.surface = std::move(surface);
  const std::string what = mesh.name + ": the volumes of its components";
  const auto labels = TRY(context.reserve(mesh::Components::bytes(mesh.positions.size()), what));
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  auto made = TRY(make_reserved_buffer<Component>(components.count(), context, what));
  Buffer<Component>& list = made->values;
  std::fill(list.begin(), list.end(), Component());
  // In the order of the triangles, on one thread: sums are always the same.
  for (const glm::uvec3& triangle : mesh.triangles) {
    const std::uint32_t number = components.of_vertex(triangle.x);
    if (number == mesh::Components::kNone) continue;
    Component& component = list[number];
    if (component.apex == mesh::Components::kNone) component.apex = triangle.x;
    component.volume.before += volume_to(sites.span(), triangle, glm::dvec3(sites[component.apex]));
    component.volume.after += volume_to(mesh.positions.span(), triangle, glm::dvec3(mesh.positions[component.apex]));
  }
  record.components = components.count();
  for (const Component& component : list) {
    record.whole.before += component.volume.before;
    record.whole.after += component.volume.after;
    record.changed_components += component.volume.is_large() ? 1 : 0;
    if (std::abs(component.volume.change()) > std::abs(record.worst_component.change())) {
      record.worst_component = component.volume;
    }
  }
  return record;
}

}  // namespace isoextract::convert
