// Attributes of a mesh that is turned, scaled, mirrored or moved.
#pragma once

#include <glm/glm.hpp>

#include "base/attribute_kind.hpp"
#include "mesh/attributes.hpp"

namespace isoextract::mesh {

// Whether map_attribute() changes the values, whatever the map.
[[nodiscard]] bool changes_with_mesh(const Attribute& attribute, AttributeKind kind);

// Maps the values as positions are mapped that go from p to linear * p + offset: vectors by `linear`, points by all of
// it, normals by the inverse of the transpose, and to the length 1. Integers become f32. Throws std::bad_alloc.
void map_attribute(Attribute& attribute, AttributeKind kind, const glm::dmat3& linear, const glm::dvec3& offset);

}  // namespace isoextract::mesh
