// The faces of voxels that meet in a corner of the grid, and which of them hang together there.
//
//        6-------7          The eight voxels around a corner: bit 1 of a number is the upper side along x, bit 2 along
//       /|      /|          y, bit 4 along z. A pattern has bit n set where voxel n is inside.
//      4-+-----5 |
//      | |  c  | |          The twelve faces: axis * 4 + quadrant. The quadrant has bit 1 for the upper side along the
//      | 2-----+-3          lower one of the other two axes, bit 2 along the higher one; the face parts the two voxels
//      |/      |/           there. The six edges: axis + 3 where it leads upward.
//      0-------1
//
// Voxels are joined by faces only: where two touch along an edge, each keeps its own two faces together. A fan is the
// faces around a corner that one goes through from edge to edge; each has a vertex of its own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace isoextract::extract {

struct CornerFans {
  std::uint8_t fans = 0;                   // 0 to 4
  std::array<std::uint8_t, 12> of_face{};  // the fan of each face that there is
  std::array<std::uint8_t, 2> doubled{};   // bits of axes, by whether the edge leads upward: where voxels touch
                                           // along this edge only and both are in one fan
};

// By pattern.
[[nodiscard]] const std::array<CornerFans, 256>& corner_fans();

}  // namespace isoextract::extract
