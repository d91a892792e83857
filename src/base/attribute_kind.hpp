// What the numbers of an attribute mean, which decides how they change where a mesh is turned, scaled or mirrored.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/words.hpp"

namespace isoextract {

enum class AttributeKind : std::uint8_t {
  scalar,  // numbers that stay as they are
  color,   // likewise
  vector,  // a displacement or a velocity: changes as the difference of two positions does
  point,   // a position
  normal   // perpendicular to a surface, of length 1
};
constexpr auto words_of(AttributeKind /*type*/) {
  return std::array{Word{AttributeKind::scalar, "scalar"}, Word{AttributeKind::color, "color"},
                    Word{AttributeKind::vector, "vector"}, Word{AttributeKind::point, "point"},
                    Word{AttributeKind::normal, "normal"}};
}

// Whether attributes of that kind change with the mesh. Only those of three components do.
[[nodiscard]] constexpr bool changes_with_mesh(AttributeKind kind) {
  return kind == AttributeKind::vector || kind == AttributeKind::point || kind == AttributeKind::normal;
}

// The kind of an attribute of several components that is called so, whatever the case: "v", "velocity", "N", "Cd", "P".
// Nothing where the name says nothing.
[[nodiscard]] std::optional<AttributeKind> kind_by_name(std::string_view name);

}  // namespace isoextract
