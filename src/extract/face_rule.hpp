// Whether the inside corners of a face are joined across it, where inside and outside alternate around its four
// corners. Both cells at the face, and the cap at the border of the data, must ask this with the same values.
#pragma once

#include "extract/cell_tables.hpp"

namespace isoextract {

// Inside corners are kept apart, unless an outside corner has the very value iso. Then the bilinear interpolant on the
// face is inside between them: the product of the outside corners' distances to iso is 0, that of the inside ones is
// not (Nielson and Hamann, "The asymptotic decider", IEEE Visualization 1991, section 2).
[[nodiscard]] inline bool joins_inside(double outside_a, double outside_b, double iso) {
  return outside_a == iso || outside_b == iso;
}

// The set of faces of a cell that are joined. `value(c)` is the field at corner c.
template <class Value>
[[nodiscard]] unsigned joined_faces(const CaseTable& table, unsigned cell_case, double iso, const Value& value) {
  unsigned joined = 0;
  for (unsigned f = 0; f < 6; ++f) {
    if ((table.alternating_faces[cell_case] >> f & 1) == 0) continue;
    const auto& corners = cell_faces()[f];
    const std::size_t outside = (cell_case >> corners[0] & 1) != 0 ? 1 : 0;
    if (joins_inside(value(corners[outside]), value(corners[outside + 2]), iso)) joined |= 1U << f;
  }
  return joined;
}

// The variant that a cell draws. Values are looked at only where the case alone does not decide.
template <class Value>
[[nodiscard]] unsigned cell_variant(const CaseTable& table, unsigned cell_case, double iso, const Value& value) {
  if (table.alternating_faces[cell_case] == 0) return table.variants[cell_case];
  return table.variant(cell_case, joined_faces(table, cell_case, iso, value));
}

}  // namespace isoextract
