// The voxel faces that meet at a grid corner, grouped into fans: faces connected with each other around the corner.
//
//        6-------7          The eight voxels around a corner: bit 1 of the voxel number is the upper side along x, bit
//       /|      /|          2 along y, bit 4 along z. A pattern has bit n set if voxel n is inside.
//      4-+-----5 |
//      | |  c  | |          The twelve faces: axis * 4 + quadrant. The quadrant has bit 1 for the upper side along the
//      | 2-----+-3          lower one of the other two axes, bit 2 along the higher one. The face separates the two
//      |/      |/           voxels of its quadrant. The six edges: by axis, and downward or upward.
//      0-------1
//
// Voxels are connected through faces only. Where two voxels touch along an edge only, the two faces of each voxel at
// this edge are connected with each other. A fan is the set of faces that a walk around the corner, from edge to edge,
// passes. Each fan has its own vertex.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace isoextract::extract {

struct CornerFans {
  std::uint8_t fans = 0;                   // number of fans, 0 to 4
  std::array<std::uint8_t, 12> of_face{};  // the fan of each exposed face
  std::array<std::uint8_t, 2> doubled{};   // axis bits, for edges leading downward [0] and upward [1]: two voxels touch
                                           // along this edge only, and both are in one fan
};

// Returns the fans of each pattern.
[[nodiscard]] const std::array<CornerFans, 256>& corner_fans();

}  // namespace isoextract::extract
