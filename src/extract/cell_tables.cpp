// Marching cubes: Lorensen and Cline, SIGGRAPH 1987; closed by a face rule as in Nielson and Hamann, "The asymptotic
// decider", IEEE Visualization 1991, section 2. Marching tetrahedra: seed S1; the six tetrahedra are Kuhn's.
#include "extract/cell_tables.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <optional>

namespace isoextract {
namespace {

using Polygon = std::vector<std::uint8_t>;  // edge indices

constexpr unsigned kAllInside = 255;

bool inside(unsigned cell_case, unsigned corner) { return (cell_case >> corner & 1) != 0; }

std::uint8_t edge_index(const CaseTable& table, unsigned corner_a, unsigned corner_b) {
  const CellEdge edge{static_cast<std::uint8_t>(std::min(corner_a, corner_b)),
                      static_cast<std::uint8_t>(corner_a ^ corner_b)};
  const auto found = std::ranges::find(table.edges, edge);
  assert(found != table.edges.end());
  return static_cast<std::uint8_t>(found - table.edges.begin());
}

// All edges along the table's directions.
void add_edges(CaseTable& table) {
  for (const std::uint8_t direction : table.directions) {
    for (std::uint8_t corner = 0; corner < 8; ++corner) {
      if ((corner & direction) == 0) table.edges.push_back({corner, direction});
    }
  }
}

// ---- marching cubes

// The corners of each face, counter-clockwise seen from outside the cell.
constexpr std::array<std::array<std::uint8_t, 4>, 6> kFaces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

bool on_face(const CellEdge& edge, const std::array<std::uint8_t, 4>& face) {
  return std::ranges::count(face, edge.corner) + std::ranges::count(face, edge.corner | edge.direction) == 2;
}

bool share_a_face(const CaseTable& table, std::uint8_t a, std::uint8_t b) {
  return std::ranges::any_of(
      kFaces, [&](const auto& face) { return on_face(table.edges[a], face) && on_face(table.edges[b], face); });
}

// For every crossed edge, the edge that the surface reaches next. Walking around a face, the surface goes from an edge
// where the walk enters the inside to the edge where it next leaves it: so inside corners of one face are kept apart.
// Every edge is entered on one of its two faces and left on the other, hence the next edges form loops.
std::array<std::optional<std::uint8_t>, 12> next_edges(const CaseTable& table, unsigned cell_case) {
  std::array<std::optional<std::uint8_t>, 12> next;
  for (const auto& face : kFaces) {
    for (unsigned corner = 0; corner < 4; ++corner) {
      if (inside(cell_case, face[corner]) || !inside(cell_case, face[(corner + 1) % 4])) continue;
      unsigned leave = corner + 1;
      while (inside(cell_case, face[(leave + 1) % 4])) ++leave;
      next[edge_index(table, face[corner], face[(corner + 1) % 4])] =
          edge_index(table, face[leave % 4], face[(leave + 1) % 4]);
    }
  }
  return next;
}

std::vector<Polygon> surface_polygons(const CaseTable& table, unsigned cell_case) {
  auto next = next_edges(table, cell_case);
  std::vector<Polygon> polygons;
  for (std::uint8_t start = 0; start < next.size(); ++start) {
    if (!next[start]) continue;
    Polygon& polygon = polygons.emplace_back();
    for (std::uint8_t edge = start; next[edge];) {
      polygon.push_back(edge);
      const std::uint8_t follower = *next[edge];
      next[edge].reset();
      edge = follower;
    }
  }
  return polygons;
}

// Cuts polygon[begin..end] (whose side begin-end is allowed) into triangles with no diagonal in a face of the cell.
// False if there is no such cut; `out` is then as it was.
bool triangulate(const CaseTable& table, const Polygon& polygon, std::size_t begin, std::size_t end,
                 std::vector<CellTriangle>& out) {
  if (end - begin < 2) return true;
  for (std::size_t apex = begin + 1; apex < end; ++apex) {
    const bool first_ok = apex == begin + 1 || !share_a_face(table, polygon[begin], polygon[apex]);
    const bool second_ok = apex + 1 == end || !share_a_face(table, polygon[apex], polygon[end]);
    if (!first_ok || !second_ok) continue;
    const std::size_t before = out.size();
    if (triangulate(table, polygon, begin, apex, out) && triangulate(table, polygon, apex, end, out)) {
      out.push_back({polygon[begin], polygon[apex], polygon[end]});
      return true;
    }
    out.resize(before);
  }
  return false;
}

CaseTable make_cubes_table() {
  CaseTable table;
  table.directions = {1, 2, 4};
  add_edges(table);
  for (unsigned cell_case = 0; cell_case <= kAllInside; ++cell_case) {
    table.first[cell_case] = static_cast<std::uint16_t>(table.triangles.size());
    for (const Polygon& polygon : surface_polygons(table, cell_case)) {
      [[maybe_unused]] const bool cut = triangulate(table, polygon, 0, polygon.size() - 1, table.triangles);
      assert(cut);  // the unit tests go through all 256 cases
    }
  }
  table.first[kAllInside + 1] = static_cast<std::uint16_t>(table.triangles.size());
  return table;
}

// ---- marching tetrahedra

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

// Each path 0 -> a -> a|b -> 7 along the axes is a tetrahedron; odd permutations have their middle corners swapped.
constexpr std::array<std::array<std::uint8_t, 4>, 6> kTetrahedra{
    {{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}}};

CaseTable make_tetrahedra_table() {
  CaseTable table;
  table.directions = {1, 2, 3, 4, 5, 6, 7};
  add_edges(table);
  for (unsigned cell_case = 0; cell_case <= kAllInside; ++cell_case) {
    table.first[cell_case] = static_cast<std::uint16_t>(table.triangles.size());
    for (const auto& corners : kTetrahedra) {
      unsigned index = 0;
      for (const std::uint8_t corner : corners) index = index << 1 | (inside(cell_case, corner) ? 1 : 0);
      if (index == 0 || index == 15) continue;
      const TetrahedronCase& drawn = kTetrahedronCases[index];
      const auto edge = [&](std::size_t strip) {
        return edge_index(table, corners[drawn.strip[strip][0]], corners[drawn.strip[strip][1]]);
      };
      // The paper's strips wind clockwise seen from outside for these tetrahedra: turned once, here.
      table.triangles.push_back({edge(0), edge(2), edge(1)});
      if (drawn.quad) table.triangles.push_back({edge(1), edge(2), edge(3)});
    }
  }
  table.first[kAllInside + 1] = static_cast<std::uint16_t>(table.triangles.size());
  return table;
}

}  // namespace

const CaseTable& case_table(Method method) {
  static const CaseTable cubes = make_cubes_table();
  static const CaseTable tetrahedra = make_tetrahedra_table();
  return method == Method::mc ? cubes : tetrahedra;
}

const std::array<TetrahedronCase, 16>& tetrahedron_cases() { return kTetrahedronCases; }

const std::array<std::array<std::uint8_t, 4>, 6>& cell_tetrahedra() { return kTetrahedra; }

}  // namespace isoextract
