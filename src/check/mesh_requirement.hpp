// Requirements that a mesh can be tested for; unmet_reason() of mesh_check.hpp tests them.
#pragma once

#include <array>

#include "base/enum_words.hpp"

namespace isoextract::check {

enum class Requirement {
  closed,
  manifold,
  oriented,
  outward,
  no_self_intersections,
  no_zero_area,
  no_duplicates,
  no_unused_vertices,
  one_component,
  normals
};
constexpr auto words_of(Requirement /*type*/) {
  return std::array{Word{Requirement::closed, "closed"},
                    Word{Requirement::manifold, "manifold"},
                    Word{Requirement::oriented, "oriented"},
                    Word{Requirement::outward, "outward"},
                    Word{Requirement::no_self_intersections, "no-self-intersections"},
                    Word{Requirement::no_zero_area, "no-zero-area"},
                    Word{Requirement::no_duplicates, "no-duplicates"},
                    Word{Requirement::no_unused_vertices, "no-unused-vertices"},
                    Word{Requirement::one_component, "one-component"},
                    Word{Requirement::normals, "normals"}};
}

}  // namespace isoextract::check
