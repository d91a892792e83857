// Transforms the attributes of a mesh that is rotated, scaled, mirrored or moved.
#pragma once

#include <glm/glm.hpp>

#include "base/attribute_kind.hpp"
#include "mesh/attributes.hpp"

namespace isoextract::mesh {

// Returns whether map_attribute() changes the values of this attribute.
[[nodiscard]] bool is_transformed_with_mesh(const Attribute& attribute, AttributeKind kind);

// Transforms the values for the map p -> linear * p + offset of the positions: vectors by `linear`, points by the whole
// map, normals by the inverse transpose, then normalized. f64 stays f64; all other types become f32. Does nothing if
// is_transformed_with_mesh() is false. If it throws std::bad_alloc, the attribute stays as it was.
void map_attribute(Attribute& attribute, AttributeKind kind, const glm::dmat3& linear, const glm::dvec3& offset);

}  // namespace isoextract::mesh
