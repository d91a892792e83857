// What a cell draws for each of its 256 sign cases. The CPU extractors read these tables, and shaders are given them as
// generated constants, so that both draw the same triangles.
//
// Corners and bits. Corner c of a cell stands at (c & 1, c >> 1 & 1, c >> 2 & 1) from the cell's lowest sample; bit c
// of the case is set where the corner is inside:
//
//        6-------7
//       /|      /|        z
//      4-------5 |        | y
//      | 2-----|-3        |/
//      |/      |/         +--x
//      0-------1
//
// Edges. A cell edge goes from a corner to corner | direction, where direction is a set of axis bits not in the
// corner: 1, 2, 4 along x, y, z; 3, 5, 6 across a face; 7 through the body (marching tetrahedra only). So every edge of
// the grid is owned by exactly one sample, its lowest, in one of at most seven directions, and that pair is its key.
//
// Triangles wind counter-clockwise seen from outside (from the corners whose bit is 0) in a right-handed index space.
// Worked case 1 (corner 0 alone inside): one triangle on the edges 0+x, 0+y, 0+z, normal (1, 1, 1).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "extract/extractor.hpp"

namespace isoextract::extract {

struct CellEdge {
  std::uint8_t corner;     // the lower end
  std::uint8_t direction;  // axis bits, never shared with the corner's

  friend bool operator==(const CellEdge&, const CellEdge&) = default;
};

using CellTriangle = std::array<std::uint8_t, 3>;  // indices into CaseTable::edges

// A variant that is drawn instead of another one where the surface has a tunnel through the cell; 0 if it cannot have.
struct Tunnel {
  std::uint16_t variant = 0;
  bool joins_inside = false;  // the tunnel joins inside corners, or outside corners
};

// What a case draws may depend on how its ambiguous faces are decided, and on tunnels: one variant for each set of
// joined faces, and after those of all cases one for each tunnel. asymptotic_decider.hpp chooses.
struct CaseTable {
  std::vector<std::uint8_t> directions;  // in the order vertices of one sample are numbered: {1, 2, 4} or {1, ..., 7}
  std::vector<CellEdge> edges;           // 12 for mc, 19 for mt
  std::array<bool, 256> ambiguous{};     // the case does not say alone what is drawn; mt: never
  // Bit f: the corners of kCubeFaces[f] (cube_cell.hpp) alternate; mt: none.
  std::array<std::uint8_t, 256> alternating_faces{};
  std::array<std::uint16_t, 256> variants{};  // the number of the case's first variant
  // By variant (none for tunnels themselves; mt: empty) and by which corners are inside in alternating slices across
  // z: 0 and 3 with those above them, or 1 and 2.
  std::vector<std::array<Tunnel, 2>> tunnels;
  std::vector<std::uint16_t> first;  // variant v draws triangles[first[v]] .. triangles[first[v + 1] - 1]
  std::vector<CellTriangle> triangles;

  // Where axis bits are in `directions`; their number if the method has no such direction.
  [[nodiscard]] std::size_t index_of(int direction) const {
    return static_cast<std::size_t>(std::ranges::find(directions, direction) - directions.begin());
  }

  // `joined` is the set of alternating faces whose inside corners are joined.
  [[nodiscard]] unsigned variant(unsigned cell_case, unsigned joined) const {
    unsigned number = 0;
    unsigned weight = 1;
    for (unsigned rest = alternating_faces[cell_case]; rest != 0; rest &= rest - 1, weight <<= 1) {
      if ((joined & rest & (0U - rest)) != 0) number += weight;
    }
    return variants[cell_case] + number;
  }

  // Fills `edges` with all edges along `directions`.
  void add_edges();
};

// mc: a disc for every loop of the surface around the cell's faces, or an annulus for two loops with a tunnel. Both
// cells at a face decide alike whether the face's alternating corners are joined, therefore the surface closes. Loops
// are cut so that no edge of the mesh has more than two triangles, whatever the neighbours draw.
// mt: the union of what the six tetrahedra around the diagonal 0-7 draw; nothing is ambiguous. After A. Yu. Suravikin,
// V. V. Korobitsyn: Visualization of a scalar field by dynamic construction of an isosurface (docs/papers.md).
[[nodiscard]] const CaseTable& case_table(Method method);

// Their section on the edge table: for each of the 16 cases of a tetrahedron (index = b0 << 3 | b1 << 2 | b2 << 1 |
// b3), four vertex pairs; a triangle strip of three vertices, or of four where the last number is not 0.
struct TetrahedronCase {
  std::array<std::array<std::uint8_t, 2>, 4> strip;
  bool quad;
};
[[nodiscard]] const std::array<TetrahedronCase, 16>& tetrahedron_cases();

// The six tetrahedra of a cell, as cell corners; all have the same handedness.
[[nodiscard]] const std::array<std::array<std::uint8_t, 4>, 6>& cell_tetrahedra();

}  // namespace isoextract::extract
