// Marching tetrahedra: Suravikin and Korobitsyn; the six tetrahedra are Kuhn's. Marching cubes: cubes_table.cpp.
#include "extract/cell_tables.hpp"

#include <algorithm>
#include <cassert>

#include "extract/cube_cell.hpp"
#include "extract/detail/cubes_table.hpp"

namespace isoextract::extract {
namespace {

std::uint8_t edge_index(const CaseTable& table, unsigned corner_a, unsigned corner_b) {
  const CellEdge edge{static_cast<std::uint8_t>(std::min(corner_a, corner_b)),
                      static_cast<std::uint8_t>(corner_a ^ corner_b)};
  const auto found = std::ranges::find(table.edges, edge);
  assert(found != table.edges.end());
  return static_cast<std::uint8_t>(found - table.edges.begin());
}

constexpr std::array<TetrahedronCase, 16> kTetrahedronCases{{
    {{{{0, 0}, {0, 0}, {0, 0}, {0, 0}}}, false},  // strip unused
    {{{{3, 0}, {3, 1}, {3, 2}, {0, 0}}}, false},
    {{{{2, 1}, {2, 0}, {2, 3}, {0, 0}}}, false},
    {{{{2, 0}, {3, 0}, {2, 1}, {3, 1}}}, true},
    {{{{1, 2}, {1, 3}, {1, 0}, {0, 0}}}, false},
    {{{{1, 0}, {1, 2}, {3, 0}, {3, 2}}}, true},
    {{{{1, 0}, {2, 0}, {1, 3}, {2, 3}}}, true},
    {{{{3, 0}, {1, 0}, {2, 0}, {0, 0}}}, false},
    {{{{0, 2}, {0, 1}, {0, 3}, {0, 0}}}, false},
    {{{{0, 1}, {3, 1}, {0, 2}, {3, 2}}}, true},
    {{{{0, 1}, {0, 3}, {2, 1}, {2, 3}}}, true},
    {{{{3, 1}, {2, 1}, {0, 1}, {0, 0}}}, false},
    {{{{0, 2}, {1, 2}, {0, 3}, {1, 3}}}, true},
    {{{{1, 2}, {3, 2}, {0, 2}, {0, 0}}}, false},
    {{{{0, 3}, {2, 3}, {1, 3}, {0, 0}}}, false},
    {{{{0, 0}, {0, 0}, {0, 0}, {0, 0}}}, false},  // strip unused
}};

// Each path 0 -> a -> a|b -> 7 along the axes is a tetrahedron. Odd permutations have their middle corners swapped to
// keep one handedness.
constexpr std::array<std::array<std::uint8_t, 4>, 6> kTetrahedra{
    {{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}}};

CaseTable make_tetrahedra_table() {
  CaseTable table;
  table.directions = {1, 2, 3, 4, 5, 6, 7};
  table.add_edges();
  for (unsigned cell_case = 0; cell_case < table.variants.size(); ++cell_case) {
    table.variants[cell_case] = static_cast<std::uint16_t>(table.first.size());
    table.first.push_back(static_cast<std::uint16_t>(table.triangles.size()));
    for (const auto& corners : kTetrahedra) {
      unsigned index = 0;
      for (const std::uint8_t corner : corners) index = index << 1 | (is_inside(cell_case, corner) ? 1 : 0);
      if (index == 0 || index == 15) continue;
      const TetrahedronCase& drawn = kTetrahedronCases[index];
      const auto edge = [&](std::size_t strip) {
        return edge_index(table, corners[drawn.strip[strip][0]], corners[drawn.strip[strip][1]]);
      };
      // The strips of the paper wind clockwise seen from outside for these tetrahedra, so the winding is reversed here.
      table.triangles.push_back({edge(0), edge(2), edge(1)});
      if (drawn.quad) table.triangles.push_back({edge(1), edge(2), edge(3)});
    }
  }
  table.first.push_back(static_cast<std::uint16_t>(table.triangles.size()));
  return table;
}

}  // namespace

void CaseTable::add_edges() {
  for (const std::uint8_t direction : directions) {
    for (std::uint8_t corner = 0; corner < 8; ++corner) {
      if ((corner & direction) == 0) edges.push_back({corner, direction});
    }
  }
}

const CaseTable& case_table(Method method) {
  static const CaseTable cubes = make_cubes_table();
  static const CaseTable tetrahedra = make_tetrahedra_table();
  return method == Method::mc ? cubes : tetrahedra;
}

const std::array<TetrahedronCase, 16>& tetrahedron_cases() { return kTetrahedronCases; }

const std::array<std::array<std::uint8_t, 4>, 6>& cell_tetrahedra() { return kTetrahedra; }

}  // namespace isoextract::extract
