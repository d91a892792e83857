#include "extract/cell_tables.hpp"

#include <map>
#include <set>

#include <gtest/gtest.h>

#include <glm/glm.hpp>
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

class CellTables : public testing::TestWithParam<Method> {
 protected:
  const CaseTable& table_ = case_table(GetParam());

  static glm::dvec3 corner_position(unsigned c) { return {c & 1, c >> 1 & 1, c >> 2 & 1}; }
  static bool inside(unsigned cell_case, unsigned corner) { return (cell_case >> corner & 1) != 0; }

  bool crossed(unsigned cell_case, const CellEdge& e) const {
    return inside(cell_case, e.corner) != inside(cell_case, e.corner | e.direction);
  }
  glm::dvec3 middle(std::uint8_t edge) const {
    const CellEdge& e = table_.edges[edge];
    return (corner_position(e.corner) + corner_position(e.corner | e.direction)) / 2.0;
  }
  std::vector<CellTriangle> triangles(unsigned variant) const {
    return {table_.triangles.begin() + table_.first[variant], table_.triangles.begin() + table_.first[variant + 1]};
  }
  // Returns the variants with a tunnel that may replace a variant.
  std::set<unsigned> tunnels(unsigned variant) const {
    std::set<unsigned> numbers;
    if (variant >= table_.tunnels.size()) return numbers;
    for (const Tunnel& tunnel : table_.tunnels[variant]) {
      if (tunnel.variant != 0) numbers.insert(tunnel.variant);
    }
    return numbers;
  }
  // Calls f(case, joined faces, variant) for every possible cell: without a tunnel, and with each possible tunnel.
  template <class F>
  void for_each_variant(const F& f) const {
    for (unsigned cell_case = 0; cell_case < 256; ++cell_case) {
      for (unsigned joined = 0; joined < 64; ++joined) {
        if ((joined & ~unsigned{table_.alternating_faces[cell_case]}) != 0) continue;
        SCOPED_TRACE(testing::Message() << "case " << cell_case << ", joined faces " << joined);
        const unsigned variant = table_.variant(cell_case, joined);
        f(cell_case, joined, variant);
        for (const unsigned tunnel : tunnels(variant)) f(cell_case, joined, tunnel);
      }
    }
  }
  using MeshEdge = std::pair<int, int>;  // two vertices, named by their cell edges

  // Returns the directed mesh edges without an opposite in the cell. They must lie in the faces of the cell.
  std::set<MeshEdge> boundary(unsigned variant) const {
    std::set<MeshEdge> edges;
    for (const CellTriangle& t : triangles(variant)) {
      for (int c = 0; c < 3; ++c) {
        const MeshEdge edge(t[c], t[(c + 1) % 3]);
        if (edges.erase({edge.second, edge.first}) == 0) {
          EXPECT_TRUE(edges.insert(edge).second) << "a directed edge is used twice";
        }
      }
    }
    return edges;
  }

  // Returns the face (as in kCubeFaces) that contains both ends of a mesh edge, or -1.
  int common_face(const MeshEdge& edge) const {
    const CellEdge& a = table_.edges[static_cast<std::size_t>(edge.first)];
    const CellEdge& b = table_.edges[static_cast<std::size_t>(edge.second)];
    for (int axis = 0; axis < 3; ++axis) {
      const int bit = 1 << axis;
      if (((a.direction | b.direction) & bit) == 0 && (a.corner & bit) == (b.corner & bit)) {
        return 2 * axis + ((a.corner & bit) != 0 ? 1 : 0);
      }
    }
    return -1;
  }

  // Renames a mesh edge in an upper face as the cell beyond that face names it.
  MeshEdge seen_from_above(const MeshEdge& edge, int axis) const {
    const auto moved = [&](int e) {
      CellEdge lower = table_.edges[static_cast<std::size_t>(e)];
      lower.corner = static_cast<std::uint8_t>(lower.corner & ~(1 << axis));
      return static_cast<int>(std::find(table_.edges.begin(), table_.edges.end(), lower) - table_.edges.begin());
    };
    return {moved(edge.first), moved(edge.second)};
  }

  // The mesh edges of a cell in one of its faces: `boundary` directed, `inner` with rising ends; both seen from above.
  struct FacePattern {
    std::set<MeshEdge> boundary;
    std::set<MeshEdge> inner;
  };
  FacePattern face_pattern(unsigned variant, int face) const {
    FacePattern pattern;
    const std::set<MeshEdge> open = boundary(variant);
    for (const CellTriangle& t : triangles(variant)) {
      for (int c = 0; c < 3; ++c) {
        const MeshEdge edge(t[c], t[(c + 1) % 3]);
        if (common_face(edge) != face) continue;
        const MeshEdge seen = face % 2 != 0 ? seen_from_above(edge, face / 2) : edge;
        if (open.contains(edge)) {
          pattern.boundary.insert(seen);
        } else {
          pattern.inner.insert(std::minmax(seen.first, seen.second));
        }
      }
    }
    return pattern;
  }
};

TEST_P(CellTables, ListEveryEdgeOnce) {
  EXPECT_EQ(table_.edges.size(), GetParam() == Method::mc ? 12U : 19U);
  std::set<std::pair<int, int>> seen;
  for (const CellEdge& e : table_.edges) {
    EXPECT_EQ(e.corner & e.direction, 0);
    EXPECT_TRUE(seen.emplace(e.corner, e.direction).second);
  }
}

TEST_P(CellTables, NumberVariantsWithoutGaps) {
  std::set<unsigned> numbers;
  for_each_variant([&](unsigned, unsigned, unsigned variant) { EXPECT_TRUE(numbers.insert(variant).second); });
  EXPECT_EQ(numbers.size(), GetParam() == Method::mc ? 656U + 148U : 256U);
  EXPECT_EQ(*numbers.rbegin() + 2, table_.first.size());
}

TEST_P(CellTables, UseExactlyTheCrossedEdges) {
  for_each_variant([&](unsigned cell_case, unsigned, unsigned variant) {
    std::set<int> expected;
    for (std::size_t e = 0; e < table_.edges.size(); ++e) {
      if (crossed(cell_case, table_.edges[e])) expected.insert(static_cast<int>(e));
    }
    std::set<int> used;
    for (const CellTriangle& t : triangles(variant)) used.insert(t.begin(), t.end());
    EXPECT_EQ(used, expected);
  });
}

TEST_P(CellTables, FaceTrianglesOutward) {
  for_each_variant([&](unsigned cell_case, unsigned joined, unsigned variant) {
    if (joined != 0 || variant >= 656) return;  // the surface of these folds back
    for (const CellTriangle& t : triangles(variant)) {
      const glm::dvec3 normal = glm::cross(middle(t[1]) - middle(t[0]), middle(t[2]) - middle(t[0]));
      glm::dvec3 outward(0);
      for (const std::uint8_t edge : t) {
        const CellEdge& e = table_.edges[edge];
        const glm::dvec3 step = corner_position(e.direction);
        outward += inside(cell_case, e.corner) ? step : -step;
      }
      EXPECT_GT(glm::dot(normal, outward), 0);
    }
  });
}

TEST_P(CellTables, PutNoTriangleInAFace) {
  for_each_variant([&](unsigned, unsigned, unsigned variant) {
    for (const CellTriangle& t : triangles(variant)) {
      const int face = common_face({t[0], t[1]});
      EXPECT_TRUE(face < 0 || common_face({t[1], t[2]}) != face || common_face({t[2], t[0]}) != face);
    }
  });
}

// A tunnel replaces the discs of two loops by an annulus: two more triangles for each loop, an Euler number lower by
// two, and the same boundary.
TEST_P(CellTables, TunnelsJoinTwoLoops) {
  const auto euler = [&](unsigned variant) {
    std::set<int> vertices;
    std::set<MeshEdge> edges;
    for (const CellTriangle& t : triangles(variant)) {
      for (int c = 0; c < 3; ++c) {
        vertices.insert(t[c]);
        edges.insert(std::minmax<int>(t[c], t[(c + 1) % 3]));
      }
    }
    return static_cast<int>(vertices.size()) - static_cast<int>(edges.size()) +
           static_cast<int>(triangles(variant).size());
  };
  for (unsigned variant = 0; variant < table_.tunnels.size(); ++variant) {
    for (const unsigned tunnel : tunnels(variant)) {
      SCOPED_TRACE(testing::Message() << "variant " << variant << " with tunnel " << tunnel);
      EXPECT_EQ(euler(tunnel), euler(variant) - 2);
      EXPECT_EQ(triangles(tunnel).size(), triangles(variant).size() + 4);
      EXPECT_EQ(boundary(tunnel), boundary(variant));
    }
  }
}

TEST_P(CellTables, CloseSurfaceWithinCell) {
  for_each_variant([&](unsigned, unsigned, unsigned variant) {
    for (const MeshEdge& edge : boundary(variant)) EXPECT_GE(common_face(edge), 0);
  });
}

// All pairs of neighboring cells: open edges of a cell in a face are open in the other direction in the cell behind it.
// No other edge in the face is drawn from both sides or twice.
TEST_P(CellTables, CloseSurfaceBetweenNeighbors) {
  for (int axis = 0; axis < 3; ++axis) {
    const unsigned bit = 1U << axis;
    std::map<std::pair<unsigned, bool>, std::vector<FacePattern>> below;  // by corners and decision of the face
    std::map<std::pair<unsigned, bool>, std::vector<FacePattern>> above;
    for_each_variant([&](unsigned cell_case, unsigned joined, unsigned variant) {
      for (const int face : {2 * axis, 2 * axis + 1}) {
        unsigned face_case = 0;
        for (unsigned c = 0; c < 8; ++c) {
          if (((c & bit) != 0) == (face % 2 != 0) && inside(cell_case, c)) face_case |= 1U << (c & ~bit);
        }
        auto& side = face % 2 != 0 ? below : above;
        side[{face_case, (joined >> face & 1) != 0}].push_back(face_pattern(variant, face));
      }
    });
    ASSERT_EQ(below.size(), above.size());
    for (const auto& [key, patterns] : below) {
      for (const FacePattern& low : patterns) {
        for (const FacePattern& high : above[key]) {
          std::set<MeshEdge> turned;
          for (const MeshEdge& edge : high.boundary) turned.insert({edge.second, edge.first});
          EXPECT_EQ(low.boundary, turned);
          for (const MeshEdge& edge : low.inner) {
            EXPECT_FALSE(high.inner.contains(edge));
            EXPECT_FALSE(low.boundary.contains(edge) || turned.contains(edge));
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, CellTables, testing::ValuesIn(test::cell_methods()), test::method_name);

TEST(CubesTable, MatchesWorkedCaseOne) {
  const CaseTable& table = case_table(Method::mc);
  const unsigned variant = table.variant(1, 0);
  ASSERT_EQ(table.first[variant + 1] - table.first[variant], 1);
  const CellTriangle& t = table.triangles[table.first[variant]];
  EXPECT_EQ(table.edges[t[0]], (CellEdge{0, 1}));
  EXPECT_EQ(table.edges[t[1]], (CellEdge{0, 2}));
  EXPECT_EQ(table.edges[t[2]], (CellEdge{0, 4}));
}

TEST(CubesTable, HasKnownTriangleCount) {
  const CaseTable& table = case_table(Method::mc);
  int triangles = 0;
  for (unsigned cell_case = 0; cell_case < 256; ++cell_case) {
    const unsigned apart = table.variant(cell_case, 0);
    triangles += table.first[apart + 1] - table.first[apart];
  }
  EXPECT_EQ(triangles, 820);
}

// The table of Suravikin and Korobitsyn: opposite cases use the same edges, and the number of inside corners fixes the
// length of the strip.
TEST(TetrahedronCases, AgreeWithCorners) {
  for (unsigned index = 1; index < 15; ++index) {
    const TetrahedronCase& drawn = tetrahedron_cases()[index];
    std::set<std::set<int>> used;
    for (int v = 0; v < (drawn.quad ? 4 : 3); ++v) used.insert({drawn.strip[v][0], drawn.strip[v][1]});
    std::set<std::set<int>> expected;
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < a; ++b) {
        if ((index >> (3 - a) & 1) != (index >> (3 - b) & 1)) expected.insert({a, b});
      }
    }
    EXPECT_EQ(used, expected) << "index " << index;
  }
}

TEST(CellTetrahedra, FillCellWithOneHandedness) {
  double volume = 0;
  for (const auto& t : cell_tetrahedra()) {
    const auto p = [&](int c) { return glm::dvec3(t[c] & 1, t[c] >> 1 & 1, t[c] >> 2 & 1); };
    const double signed_volume = glm::dot(glm::cross(p(1) - p(0), p(2) - p(0)), p(3) - p(0)) / 6;
    EXPECT_NEAR(signed_volume, 1.0 / 6, 1e-15);
    volume += signed_volume;
  }
  EXPECT_NEAR(volume, 1, 1e-14);
}

}  // namespace
}  // namespace isoextract::extract
