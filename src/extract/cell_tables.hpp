// The triangles of a cell for each of its 256 sign cases. The CPU extractors read these tables, and the shaders get
// them as generated constants, so both draw the same triangles.
//
// Corners and bits. Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2 & 1) relative to the cell's lowest sample. Bit
// c of the case is set if the corner is inside:
//
//        6-------7
//       /|      /|        z
//      4-------5 |        | y
//      | 2-----|-3        |/
//      |/      |/         +--x
//      0-------1
//
// Edges. A cell edge goes from a corner to corner | direction. The direction is a set of axis bits that the corner does
// not have: 1, 2, 4 along x, y, z. Marching tetrahedra also have 3, 5, 6 across a face and 7 through the body. The
// sample at the lower end of an edge owns it. The edge's key is this sample and one of at most seven directions.
//
// Triangles wind counter-clockwise seen from outside (from the corners whose bit is 0) in a right-handed index space.
// Example, of marching cubes: case 1 (only corner 0 inside) has one triangle on the edges 0+x, 0+y, 0+z with the normal
// (1, 1, 1).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "extract/extractor.hpp"

namespace isoextract::extract {

struct CellEdge {
  std::uint8_t corner;     // the lower end
  std::uint8_t direction;  // axis bits; the corner has none of them

  friend bool operator==(const CellEdge&, const CellEdge&) = default;
};

using CellTriangle = std::array<std::uint8_t, 3>;  // indices into CaseTable::edges

// The variant to draw instead of another one if the surface has a tunnel through the cell; 0 if no tunnel is possible.
struct Tunnel {
  std::uint16_t variant = 0;
  bool joins_inside = false;  // true: the tunnel joins inside corners; false: outside corners
};

// The triangles of a case may depend on the decisions of its ambiguous faces and on tunnels. At an ambiguous face the
// inside corners are joined or apart; a case has a variant for each combination of these decisions. All variants with
// tunnels come last. asymptotic_decider.hpp chooses the variant.
struct CaseTable {
  std::vector<std::uint8_t> directions;  // of the edges that a sample owns: {1, 2, 4} or {1, ..., 7}. Their vertices
                                         // are numbered in this order
  std::vector<CellEdge> edges;           // 12 for mc, 19 for mt
  std::array<bool, 256> ambiguous{};     // the case alone does not decide the triangles; mt: always false
  // Bit f: the corners of kCubeFaces[f] (cube_cell.hpp) alternate; mt: always 0.
  std::array<std::uint8_t, 256> alternating_faces{};
  std::array<std::uint16_t, 256> variants{};  // number of the case's first variant
  // The possible tunnels of each variant (no entry for a variant that has a tunnel; mt: empty). A slice of the cell at
  // one z has four corners, one on each vertical edge. tunnels[v][0] is for slices that are inside on the edges 0-4 and
  // 3-7 and outside on 1-5 and 2-6, tunnels[v][1] for the reverse.
  std::vector<std::array<Tunnel, 2>> tunnels;
  std::vector<std::uint16_t> first;  // variant v has triangles[first[v]] to triangles[first[v + 1] - 1]
  std::vector<CellTriangle> triangles;

  // Returns the index of axis bits in `directions`, or directions.size() if the method has no such direction.
  [[nodiscard]] std::size_t index_of(int direction) const {
    return static_cast<std::size_t>(std::ranges::find(directions, direction) - directions.begin());
  }

  // Returns the variant of a case; `joined` has bit f set if the inside corners of alternating face f are joined.
  [[nodiscard]] unsigned variant(unsigned cell_case, unsigned joined) const {
    unsigned number = 0;
    unsigned weight = 1;
    for (unsigned rest = alternating_faces[cell_case]; rest != 0; rest &= rest - 1, weight <<= 1) {
      if ((joined & rest & (0U - rest)) != 0) number += weight;
    }
    return variants[cell_case] + number;
  }

  // Fills `edges` with all cell edges along `directions`, by direction, then by corner.
  void add_edges();
};

// Returns the table of a method (mc or mt).
// mc: the surface crosses the cell's faces in closed loops. A disc fills each loop; a tunnel joins two loops by an
// annulus. Both cells at a face make the same decision about its alternating corners, so the surface closes. Loops are
// triangulated so that no mesh edge gets more than two triangles, whatever the neighboring cells draw.
// mt: the triangles of the six tetrahedra around the diagonal 0-7; no case is ambiguous. After A. Yu. Suravikin, V. V.
// Korobitsyn: Visualization of a scalar field by dynamic construction of an isosurface (docs/papers.md).
[[nodiscard]] const CaseTable& case_table(Method method);

// The edge table of Suravikin and Korobitsyn. One entry for each of the 16 cases of a tetrahedron (index = b0 << 3 | b1
// << 2 | b2 << 1 | b3; bN is 1 if vertex N is inside). `strip` holds four vertex pairs (edges): a triangle strip of
// three vertices, or of four if `quad` is true.
struct TetrahedronCase {
  std::array<std::array<std::uint8_t, 2>, 4> strip;
  bool quad;
};
[[nodiscard]] const std::array<TetrahedronCase, 16>& tetrahedron_cases();

// Returns the six tetrahedra of a cell, as cell corners; all have the same handedness.
[[nodiscard]] const std::array<std::array<std::uint8_t, 4>, 6>& cell_tetrahedra();

}  // namespace isoextract::extract
