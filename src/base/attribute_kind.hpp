// The meaning of an attribute's values. It decides how they change when a mesh is rotated, scaled or mirrored.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/enum_words.hpp"

namespace isoextract {

enum class AttributeKind : std::uint8_t {
  scalar,  // unchanged by any transform
  color,   // unchanged by any transform
  vector,  // a displacement or a velocity: transformed like the difference of two positions
  point,   // a position
  normal   // a unit vector perpendicular to a surface
};
constexpr auto words_of(AttributeKind /*type*/) {
  return std::array{Word{AttributeKind::scalar, "scalar"}, Word{AttributeKind::color, "color"},
                    Word{AttributeKind::vector, "vector"}, Word{AttributeKind::point, "point"},
                    Word{AttributeKind::normal, "normal"}};
}

// Returns whether attributes of this kind are transformed with the mesh. The caller checks the number of components:
// only attributes of three are transformed.
[[nodiscard]] constexpr bool is_transformed_with_mesh(AttributeKind kind) {
  return kind == AttributeKind::vector || kind == AttributeKind::point || kind == AttributeKind::normal;
}

// Returns the kind that a name suggests for an attribute of several components ("v", "velocity", "N", "Cd", "P"),
// ignoring case. Returns nothing if the name suggests none, or contains "angular": angular velocities do not scale with
// lengths.
[[nodiscard]] std::optional<AttributeKind> kind_by_name(std::string_view name);

}  // namespace isoextract
