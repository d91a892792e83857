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

constexpr unsigned kCases = 256;

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

constexpr std::array<std::array<std::uint8_t, 4>, 6> kFaces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

bool on_face(const CellEdge& edge, const std::array<std::uint8_t, 4>& face) {
  return std::ranges::count(face, edge.corner) + std::ranges::count(face, edge.corner | edge.direction) == 2;
}

// For every crossed edge, the edge that the surface reaches next. Walking around a face, the surface starts at an edge
// where the walk enters the inside. It ends where the walk next leaves the inside (inside corners apart), or where it
// last left it (inside corners joined); that is the same place unless the corners alternate. Every edge is a start on
// one of its two faces and an end on the other, hence the next edges form loops.
std::array<std::optional<std::uint8_t>, 12> next_edges(const CaseTable& table, unsigned cell_case, unsigned joined) {
  std::array<std::optional<std::uint8_t>, 12> next;
  for (unsigned f = 0; f < kFaces.size(); ++f) {
    const auto& face = kFaces[f];
    for (unsigned corner = 0; corner < 4; ++corner) {
      if (inside(cell_case, face[corner]) || !inside(cell_case, face[(corner + 1) % 4])) continue;
      unsigned leave = corner;
      if ((joined >> f & 1) != 0) {
        leave += 3;
        while (!inside(cell_case, face[leave % 4])) --leave;
      } else {
        leave += 1;
        while (inside(cell_case, face[(leave + 1) % 4])) ++leave;
      }
      next[edge_index(table, face[corner], face[(corner + 1) % 4])] =
          edge_index(table, face[leave % 4], face[(leave + 1) % 4]);
    }
  }
  return next;
}

std::vector<Polygon> surface_polygons(const CaseTable& table, unsigned cell_case, unsigned joined) {
  auto next = next_edges(table, cell_case, joined);
  std::vector<Polygon> polygons;
  for (std::size_t start = 0; start < next.size(); ++start) {
    if (!next[start]) continue;
    Polygon& polygon = polygons.emplace_back();
    for (auto edge = static_cast<std::uint8_t>(start); next[edge];) {
      polygon.push_back(edge);
      const std::uint8_t follower = *next[edge];
      next[edge].reset();
      edge = follower;
    }
  }
  return polygons;
}

enum class Diagonals { within_the_cell, also_in_owned_places };

// A diagonal in a face could be drawn from both sides of the face, and would then have four triangles. Most polygons
// can do without; for the others the cell below a face owns the two diagonals between opposite edges of the face, and
// the cell above it all others.
bool may_draw(const CaseTable& table, std::uint8_t a, std::uint8_t b, Diagonals diagonals) {
  for (unsigned f = 0; f < kFaces.size(); ++f) {
    if (!on_face(table.edges[a], kFaces[f]) || !on_face(table.edges[b], kFaces[f])) continue;
    const bool opposite = table.edges[a].direction == table.edges[b].direction;
    const bool cell_is_below = f % 2 == 1;
    return diagonals == Diagonals::also_in_owned_places && opposite == cell_is_below;
  }
  return true;
}

// Cuts polygon[begin..end] (whose side begin-end is given) into triangles. False if there is no such cut; `out` is then
// as it was.
bool triangulate(const CaseTable& table, const Polygon& polygon, std::size_t begin, std::size_t end,
                 Diagonals diagonals, std::vector<CellTriangle>& out) {
  if (end - begin < 2) return true;
  for (std::size_t apex = begin + 1; apex < end; ++apex) {
    if (apex > begin + 1 && !may_draw(table, polygon[begin], polygon[apex], diagonals)) continue;
    if (apex + 1 < end && !may_draw(table, polygon[apex], polygon[end], diagonals)) continue;
    const std::size_t before = out.size();
    if (triangulate(table, polygon, begin, apex, diagonals, out) &&
        triangulate(table, polygon, apex, end, diagonals, out)) {
      out.push_back({polygon[begin], polygon[apex], polygon[end]});
      return true;
    }
    out.resize(before);
  }
  return false;
}

std::uint8_t alternating_faces(unsigned cell_case) {
  unsigned faces = 0;
  for (unsigned f = 0; f < kFaces.size(); ++f) {
    const auto in = [&](std::size_t c) { return inside(cell_case, kFaces[f][c]); };
    if (in(0) == in(2) && in(1) == in(3) && in(0) != in(1)) faces |= 1U << f;
  }
  return static_cast<std::uint8_t>(faces);
}

CaseTable make_cubes_table() {
  CaseTable table;
  table.directions = {1, 2, 4};
  add_edges(table);
  for (unsigned cell_case = 0; cell_case < kCases; ++cell_case) {
    const unsigned faces = alternating_faces(cell_case);
    table.alternating_faces[cell_case] = static_cast<std::uint8_t>(faces);
    table.variants[cell_case] = static_cast<std::uint16_t>(table.first.size());
    // The subsets of `faces`, in the order of table.variant().
    unsigned joined = 0;
    do {
      table.first.push_back(static_cast<std::uint16_t>(table.triangles.size()));
      for (const Polygon& polygon : surface_polygons(table, cell_case, joined)) {
        const std::size_t last = polygon.size() - 1;
        [[maybe_unused]] const bool cut =
            triangulate(table, polygon, 0, last, Diagonals::within_the_cell, table.triangles) ||
            triangulate(table, polygon, 0, last, Diagonals::also_in_owned_places, table.triangles);
        assert(cut);  // the unit tests go through all variants
      }
      joined = (joined - faces) & faces;
    } while (joined != 0);
  }
  table.first.push_back(static_cast<std::uint16_t>(table.triangles.size()));
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
  for (unsigned cell_case = 0; cell_case < kCases; ++cell_case) {
    table.variants[cell_case] = static_cast<std::uint16_t>(table.first.size());
    table.first.push_back(static_cast<std::uint16_t>(table.triangles.size()));
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
  table.first.push_back(static_cast<std::uint16_t>(table.triangles.size()));
  return table;
}

}  // namespace

const CaseTable& case_table(Method method) {
  static const CaseTable cubes = make_cubes_table();
  static const CaseTable tetrahedra = make_tetrahedra_table();
  return method == Method::mc ? cubes : tetrahedra;
}

const std::array<std::array<std::uint8_t, 4>, 6>& cell_faces() { return kFaces; }

const std::array<TetrahedronCase, 16>& tetrahedron_cases() { return kTetrahedronCases; }

const std::array<std::array<std::uint8_t, 4>, 6>& cell_tetrahedra() { return kTetrahedra; }

}  // namespace isoextract
