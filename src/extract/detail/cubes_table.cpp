// Marching cubes: Lorensen and Cline, SIGGRAPH 1987. Faces as in Nielson and Hamann, "The asymptotic decider", IEEE
// Visualization 1991; tunnels as in Chernyaev, "Marching Cubes 33", CERN CN 95-17, 1995, and Nielson, "On marching
// cubes", IEEE TVCG 9(3), 2003. The cutting of loops into triangles is this project's own.
#include "extract/detail/cubes_table.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <optional>

#include <glm/glm.hpp>

#include "extract/cube_cell.hpp"
#include "extract/detail/tunnel_cases.hpp"

namespace isoextract::extract {
namespace {

using Triangles = std::vector<CellTriangle>;

// Returns, for every crossed edge, the edge that the surface reaches next. Walking around a face, the surface starts at
// an edge where the walk enters the inside. It ends where the walk next leaves the inside (inside corners apart), or
// where it last left it (inside corners joined). Both are the same edge unless the corners alternate. Every crossed
// edge is a start on one of its faces and an end on the other, so the next edges form loops.
std::array<std::optional<std::uint8_t>, 12> next_edges(unsigned cell_case, unsigned joined) {
  std::array<std::optional<std::uint8_t>, 12> next;
  for (unsigned f = 0; f < kCubeFaces.size(); ++f) {
    const auto& face = kCubeFaces[f];
    for (unsigned corner = 0; corner < 4; ++corner) {
      if (is_inside(cell_case, face[corner]) || !is_inside(cell_case, face[(corner + 1) % 4])) continue;
      unsigned leave = corner;
      if ((joined >> f & 1) != 0) {
        leave += 3;
        while (!is_inside(cell_case, face[leave % 4])) --leave;
      } else {
        leave += 1;
        while (is_inside(cell_case, face[(leave + 1) % 4])) ++leave;
      }
      next[cube_edge(face[corner], face[(corner + 1) % 4])] = cube_edge(face[leave % 4], face[(leave + 1) % 4]);
    }
  }
  return next;
}

std::vector<Loop> surface_loops(unsigned cell_case, unsigned joined) {
  auto next = next_edges(cell_case, joined);
  std::vector<Loop> loops;
  for (std::size_t start = 0; start < next.size(); ++start) {
    if (!next[start]) continue;
    Loop& loop = loops.emplace_back();
    for (auto edge = static_cast<std::uint8_t>(start); next[edge];) {
      loop.push_back(edge);
      const std::uint8_t follower = *next[edge];
      next[edge].reset();
      edge = follower;
    }
  }
  return loops;
}

std::uint8_t alternating_faces(unsigned cell_case) {
  unsigned faces = 0;
  for (unsigned f = 0; f < kCubeFaces.size(); ++f) {
    const auto in = [&](std::size_t c) { return is_inside(cell_case, kCubeFaces[f][c]); };
    if (in(0) == in(2) && in(1) == in(3) && in(0) != in(1)) faces |= 1U << f;
  }
  return static_cast<std::uint8_t>(faces);
}

// Triangulates loops without new vertices, so that no mesh edge has more than two triangles whatever the neighboring
// cells draw.
//
// A mesh edge inside the cell's surface that lies in a cell face could be drawn from both sides of the face, and would
// then have four triangles. Most loops need no such edge. For the others, each diagonal of a face belongs to one of the
// two cells.
class LoopCutter {
 public:
  LoopCutter(const CaseTable& table, unsigned cell_case, bool owned_places)
      : table_(table), cell_case_(cell_case), owned_places_(owned_places) {}

  // Cuts a loop into a disc. Returns false if there is no valid cut; `out` is then unchanged.
  bool cut_disc(const Loop& loop, Triangles& out) const { return cut_disc(loop, 0, loop.size() - 1, out); }

  // Cuts an annulus between two loops: of all cuts the one whose edges have the least sum of squared lengths. Seen from
  // outside, one loop runs against the other.
  bool cut_annulus(const Loop& a, const Loop& b, Triangles& out) const {
    Loop against(b.rbegin(), b.rend());
    std::optional<Strip> best;
    for (std::size_t turn = 0; turn < against.size(); ++turn) {
      std::rotate(against.begin(), against.begin() + 1, against.end());
      Strip strip = shortest_strip(a, against);
      if (strip.cost < kNone && (!best || strip.cost < best->cost)) best = std::move(strip);
    }
    if (!best) return false;
    out.insert(out.end(), best->triangles.begin(), best->triangles.end());
    return true;
  }

 private:
  static constexpr int kNone = std::numeric_limits<int>::max() / 2;

  struct Strip {
    int cost = kNone;
    Triangles triangles;
  };

  [[nodiscard]] bool on_face(std::uint8_t edge, unsigned face) const {
    const CellEdge& e = table_.edges[edge];
    return std::ranges::count(kCubeFaces[face], e.corner) +
               std::ranges::count(kCubeFaces[face], e.corner | e.direction) ==
           2;
  }

  [[nodiscard]] bool may_draw(std::uint8_t a, std::uint8_t b) const {
    for (unsigned f = 0; f < kCubeFaces.size(); ++f) {
      if (on_face(a, f) && on_face(b, f)) return owned_places_ && owns(f, table_.edges[a], table_.edges[b]);
    }
    return true;
  }

  // Returns whether this cell, of the two at a face, may draw a diagonal of the face. The rule depends only on the
  // corners of the face. It was found by search: with it, every variant has a valid cut.
  [[nodiscard]] bool owns(unsigned face, const CellEdge& a, const CellEdge& b) const {
    const bool cell_is_below = face % 2 == 1;
    const unsigned normal = 1U << face / 2;
    const unsigned first = 1U << (face / 2 + 1) % 3;  // the axes of the face
    const unsigned second = 7U & ~normal & ~first;
    const bool lowest_inside = is_inside(cell_case_, cell_is_below ? normal : 0);
    const CellEdge& along_first = a.direction == first ? a : b;
    const bool chosen = a.direction == b.direction ? a.direction == first : (along_first.corner & second) == 0;
    return (chosen != lowest_inside) == cell_is_below;
  }

  // Returns whether a triangle lies in a cell face, where it could overlap a triangle of the neighboring cell.
  [[nodiscard]] bool lies_in_a_face(const CellTriangle& t) const {
    for (unsigned f = 0; f < kCubeFaces.size(); ++f) {
      if (on_face(t[0], f) && on_face(t[1], f) && on_face(t[2], f)) return true;
    }
    return false;
  }

  // Cuts loop[begin..end]; the side from begin to end already exists.
  bool cut_disc(const Loop& loop, std::size_t begin, std::size_t end, Triangles& out) const {
    if (end - begin < 2) return true;
    for (std::size_t apex = begin + 1; apex < end; ++apex) {
      if (apex > begin + 1 && !may_draw(loop[begin], loop[apex])) continue;
      if (apex + 1 < end && !may_draw(loop[apex], loop[end])) continue;
      const CellTriangle triangle{loop[begin], loop[apex], loop[end]};
      if (lies_in_a_face(triangle)) continue;
      const std::size_t before = out.size();
      if (cut_disc(loop, begin, apex, out) && cut_disc(loop, apex, end, out)) {
        out.push_back(triangle);
        return true;
      }
      out.resize(before);
    }
    return false;
  }

  // Returns the squared distance between the middles of two edges, in quarters.
  [[nodiscard]] int squared_length(std::uint8_t a, std::uint8_t b) const {
    const auto twice_middle = [&](std::uint8_t edge) {
      const CellEdge& e = table_.edges[edge];
      const auto coordinate = [&](int axis) { return (e.corner >> axis & 1) * 2 + (e.direction >> axis & 1); };
      return glm::ivec3(coordinate(0), coordinate(1), coordinate(2));
    };
    const glm::ivec3 d = twice_middle(a) - twice_middle(b);
    return d.x * d.x + d.y * d.y + d.z * d.z;
  }

  // Returns the shortest strip that starts and ends with the edge from a[0] to b[0] and goes once around both loops.
  // The search walks over the lattice of pairs (i, j); a step along a or b is a triangle. Returns no strip if it would
  // go around one loop from a single vertex of the other, because it would use an edge twice.
  [[nodiscard]] Strip shortest_strip(const Loop& a, const Loop& b) const {
    const std::size_t rows = a.size();
    const std::size_t columns = b.size();
    if (!may_draw(a[0], b[0])) return {};
    std::vector<std::vector<int>> cost(rows + 1, std::vector<int>(columns + 1, kNone));
    std::vector<std::vector<bool>> along_a(rows + 1, std::vector<bool>(columns + 1, false));
    cost[0][0] = 0;
    for (std::size_t i = 0; i <= rows; ++i) {
      for (std::size_t j = 0; j <= columns; ++j) {
        if ((i == 0 && j == 0) || !may_draw(a[i % rows], b[j % columns])) continue;
        const auto step = [&](std::size_t from_i, std::size_t from_j, const CellTriangle& triangle) {
          return lies_in_a_face(triangle) ? kNone : cost[from_i][from_j];
        };
        const std::uint8_t at_a = a[i % rows];
        const std::uint8_t at_b = b[j % columns];
        const int from_a = i > 0 ? step(i - 1, j, {a[i - 1], at_a, at_b}) : kNone;
        const int from_b = j > 0 ? step(i, j - 1, {at_b, b[j - 1], at_a}) : kNone;
        along_a[i][j] = from_a <= from_b;
        if (std::min(from_a, from_b) < kNone) {
          cost[i][j] = std::min(from_a, from_b) + squared_length(at_a, at_b);
        }
      }
    }
    Strip strip{cost[rows][columns], {}};
    if (strip.cost == kNone) return strip;
    for (std::size_t i = rows, j = columns; i + j > 0;) {
      const std::uint8_t at_a = a[i % rows];
      const std::uint8_t at_b = b[j % columns];
      if (along_a[i][j]) {
        strip.triangles.push_back({a[--i], at_a, at_b});
      } else {
        strip.triangles.push_back({at_b, b[--j], at_a});
      }
    }
    const auto met_twice = [&](std::uint8_t vertex, const Loop& around) {
      const auto fan = [&](const CellTriangle& t) {
        return std::ranges::count(t, vertex) == 1 &&
               std::ranges::count_if(t, [&](std::uint8_t v) { return std::ranges::count(around, v) != 0; }) == 2;
      };
      return std::ranges::count_if(strip.triangles, fan) == std::ssize(around);
    };
    const bool repeated = std::ranges::any_of(a, [&](std::uint8_t v) { return met_twice(v, b); }) ||
                          std::ranges::any_of(b, [&](std::uint8_t v) { return met_twice(v, a); });
    return repeated ? Strip{} : strip;
  }

  const CaseTable& table_;
  unsigned cell_case_;
  bool owned_places_;
};

// Appends a variant with a tunnel between loops `a` and `b`; without a tunnel if a == b.
std::uint16_t add_variant(CaseTable& table, unsigned cell_case, const std::vector<Loop>& loops, std::size_t a,
                          std::size_t b) {
  const auto number = static_cast<std::uint16_t>(table.first.size());
  table.first.push_back(static_cast<std::uint16_t>(table.triangles.size()));
  const LoopCutter within_the_cell(table, cell_case, false);
  const LoopCutter also_in_owned_places(table, cell_case, true);
  for (std::size_t l = 0; l < loops.size(); ++l) {
    if (a != b && l == b) continue;
    [[maybe_unused]] const bool cut = a != b && l == a
                                          ? within_the_cell.cut_annulus(loops[a], loops[b], table.triangles) ||
                                                also_in_owned_places.cut_annulus(loops[a], loops[b], table.triangles)
                                          : within_the_cell.cut_disc(loops[l], table.triangles) ||
                                                also_in_owned_places.cut_disc(loops[l], table.triangles);
    assert(cut);  // the unit tests build all variants
  }
  return number;
}

void add_tunnels(CaseTable& table, unsigned cell_case, unsigned joined, unsigned variant) {
  const std::vector<Loop> loops = surface_loops(cell_case, joined);
  std::array<Tunnel, 2>& tunnels = table.tunnels[variant];
  for (const TunnelCase& t : tunnel_cases(cell_case, joined, loops)) {
    // The other pattern may give the same tunnel.
    const Tunnel& other = tunnels[1 - t.pattern];
    const bool known = other.variant != 0 && other.joins_inside == t.joins_inside;
    tunnels[t.pattern] = {known ? other.variant : add_variant(table, cell_case, loops, t.loop_a, t.loop_b),
                          t.joins_inside};
    table.ambiguous[cell_case] = true;
  }
}

}  // namespace

CaseTable make_cubes_table() {
  CaseTable table;
  table.directions = {1, 2, 4};
  table.add_edges();
  struct Decided {
    unsigned cell_case;
    unsigned joined;
  };
  std::vector<Decided> decided;  // by variant
  for (unsigned cell_case = 0; cell_case < table.variants.size(); ++cell_case) {
    const unsigned faces = alternating_faces(cell_case);
    table.alternating_faces[cell_case] = static_cast<std::uint8_t>(faces);
    table.ambiguous[cell_case] = faces != 0;
    table.variants[cell_case] = static_cast<std::uint16_t>(table.first.size());
    // All subsets of `faces`, in the order of table.variant().
    unsigned joined = 0;
    do {
      add_variant(table, cell_case, surface_loops(cell_case, joined), 0, 0);
      decided.push_back({cell_case, joined});
      joined = (joined - faces) & faces;
    } while (joined != 0);
  }
  table.tunnels.resize(decided.size());
  for (unsigned v = 0; v < decided.size(); ++v) add_tunnels(table, decided[v].cell_case, decided[v].joined, v);
  table.first.push_back(static_cast<std::uint16_t>(table.triangles.size()));
  return table;
}

}  // namespace isoextract::extract
