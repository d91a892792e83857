// Corners, edges and faces of a cubic cell by number; corners and case bits as in cell_tables.hpp.
#pragma once

#include <array>
#include <cstdint>

namespace isoextract::extract {

[[nodiscard]] constexpr bool is_inside(unsigned cell_case, unsigned corner) { return (cell_case >> corner & 1) != 0; }

// Returns the number (0 to 11) of the edge between two corners: edges along x first, then y, then z, each by lower
// corner.
[[nodiscard]] constexpr std::uint8_t cube_edge(unsigned corner_a, unsigned corner_b) {
  const unsigned low = corner_a & corner_b;
  switch (corner_a ^ corner_b) {
    case 1: return static_cast<std::uint8_t>(low >> 1);
    case 2: return static_cast<std::uint8_t>(4 + (low >> 2 << 1 | (low & 1)));
    default: return static_cast<std::uint8_t>(8 + low);
  }
}

// The corners of the faces x = 0, x = 1, y = 0, y = 1, z = 0, z = 1, counter-clockwise seen from outside the cell.
inline constexpr std::array<std::array<std::uint8_t, 4>, 6> kCubeFaces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

// Returns the face that contains the edge between the two corners and is parallel to `axis` (not the edge's own axis).
[[nodiscard]] constexpr unsigned cube_side_face(unsigned corner_a, unsigned corner_b, unsigned axis) {
  const unsigned along = corner_a ^ corner_b;
  const unsigned normal = 7U & ~along & ~(1U << axis);  // one bit
  return (normal == 1 ? 0 : normal == 2 ? 2 : 4) + ((corner_a & normal) != 0 ? 1 : 0);
}

}  // namespace isoextract::extract
