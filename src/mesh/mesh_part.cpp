#include "mesh/mesh_part.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace isoextract::mesh {

Result<Mesh> copy_part(const Mesh& mesh, const PartRange& part, PartData data, const Context& context) {
  std::uint64_t attribute_bytes = 0;
  if (data == PartData::attributes) {
    for (const Attribute& attribute : mesh.attributes) attribute_bytes += attribute.stride();
  }
  auto memory =
      TRY(context.reserve(part.vertices * (sizeof(glm::vec3) + attribute_bytes) + part.triangles * sizeof(glm::uvec3),
                          fmt::format("{}: one of its meshes", mesh.name)));
  Mesh copy;
  copy.name = mesh.name;
  copy.origin = mesh.origin;
  copy.positions = Buffer<glm::vec3>(part.vertices);
  copy.triangles = Buffer<glm::uvec3>(part.triangles);
  std::ranges::copy(mesh.positions.span().subspan(part.first_vertex, part.vertices), copy.positions.begin());
  std::ranges::transform(mesh.triangles.span().subspan(part.first_triangle, part.triangles), copy.triangles.begin(),
                         [&](const glm::uvec3& t) { return t - static_cast<std::uint32_t>(part.first_vertex); });
  if (data == PartData::attributes) {
    for (const Attribute& attribute : mesh.attributes) {
      Attribute& own = copy.attributes.emplace_back(attribute.without_values());
      own.values = Buffer<std::byte>(part.vertices * own.stride());
      std::ranges::copy(attribute.values.span().subspan(part.first_vertex * own.stride(), own.values.size()),
                        own.values.begin());
    }
  }
  copy.memory = std::move(memory);
  return copy;
}

}  // namespace isoextract::mesh
