#include "mesh/attribute_map.hpp"

#include <cstddef>
#include <cstring>
#include <utility>

#include "base/parallel.hpp"

namespace isoextract::mesh {

bool is_transformed_with_mesh(const Attribute& attribute, AttributeKind kind) {
  return attribute.components == 3 && attribute.role == AttributeRole::other &&
         isoextract::is_transformed_with_mesh(kind);
}

void map_attribute(Attribute& attribute, AttributeKind kind, const glm::dmat3& linear, const glm::dvec3& offset) {
  if (!is_transformed_with_mesh(attribute, kind)) return;
  const glm::dmat3 matrix = kind == AttributeKind::normal ? glm::inverse(glm::transpose(linear)) : linear;
  const glm::dvec3 moved_by = kind == AttributeKind::point ? offset : glm::dvec3(0);
  const auto image_of = [&](const glm::dvec3& value) {
    const glm::dvec3 image = matrix * value + moved_by;
    const double length = glm::length(image);
    return kind == AttributeKind::normal && length > 0 ? image / length : image;
  };
  Attribute mapped = attribute.without_values();
  if (mapped.type != ComponentType::f64) mapped.type = ComponentType::f32;
  mapped.normalized = false;
  const std::size_t vertices = attribute.values.size() / attribute.stride();
  mapped.values = Buffer<std::byte>(vertices * mapped.stride());
  for_each_range(vertices, 1 << 12, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v != end; ++v) {
      const std::byte* from = attribute.at(v).data();
      const std::size_t size = component_size(attribute.type);
      glm::dvec3 value;
      for (int c = 0; c < 3; ++c) {
        value[c] = component_value(from + static_cast<std::size_t>(c) * size, attribute.type, attribute.normalized);
      }
      value = image_of(value);
      std::byte* to = mapped.values.data() + v * mapped.stride();
      if (mapped.type == ComponentType::f64) {
        std::memcpy(to, &value, sizeof value);
      } else {
        const glm::vec3 rounded(value);
        std::memcpy(to, &rounded, sizeof rounded);
      }
    }
  });
  attribute = std::move(mapped);
}

}  // namespace isoextract::mesh
