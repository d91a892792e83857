#include "extract/cell_tables.hpp"

#include <map>
#include <set>

#include <gtest/gtest.h>

#include <glm/glm.hpp>
#include "support/meshes.hpp"

namespace isoextract {
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
  std::vector<CellTriangle> triangles(unsigned cell_case) const {
    return {table_.triangles.begin() + table_.first[cell_case], table_.triangles.begin() + table_.first[cell_case + 1]};
  }
  // Directed mesh edges that have no opposite within the cell: they must lie in the cell's faces.
  std::set<std::pair<int, int>> border(unsigned cell_case) const {
    std::set<std::pair<int, int>> edges;
    for (const CellTriangle& t : triangles(cell_case)) {
      for (int c = 0; c < 3; ++c) {
        const std::pair<int, int> edge(t[c], t[(c + 1) % 3]);
        if (edges.erase({edge.second, edge.first}) == 0) {
          EXPECT_TRUE(edges.insert(edge).second) << "case " << cell_case << " uses a directed edge twice";
        }
      }
    }
    return edges;
  }
};

TEST_P(CellTables, EdgesAreAllThereOnce) {
  EXPECT_EQ(table_.edges.size(), GetParam() == Method::mc ? 12U : 19U);
  std::set<std::pair<int, int>> seen;
  for (const CellEdge& e : table_.edges) {
    EXPECT_EQ(e.corner & e.direction, 0);
    EXPECT_TRUE(seen.emplace(e.corner, e.direction).second);
  }
}

TEST_P(CellTables, EveryCaseUsesExactlyItsCrossedEdges) {
  for (unsigned cell_case = 0; cell_case < 256; ++cell_case) {
    std::set<int> expected;
    for (std::size_t e = 0; e < table_.edges.size(); ++e) {
      if (crossed(cell_case, table_.edges[e])) expected.insert(static_cast<int>(e));
    }
    std::set<int> used;
    for (const CellTriangle& t : triangles(cell_case)) used.insert(t.begin(), t.end());
    EXPECT_EQ(used, expected) << "case " << cell_case;
  }
}

TEST_P(CellTables, EveryTriangleFacesOutside) {
  for (unsigned cell_case = 0; cell_case < 256; ++cell_case) {
    for (const CellTriangle& t : triangles(cell_case)) {
      const glm::dvec3 normal = glm::cross(middle(t[1]) - middle(t[0]), middle(t[2]) - middle(t[0]));
      glm::dvec3 outward(0);
      for (const std::uint8_t edge : t) {
        const CellEdge& e = table_.edges[edge];
        const glm::dvec3 step = corner_position(e.direction);
        outward += inside(cell_case, e.corner) ? step : -step;
      }
      EXPECT_GT(glm::dot(normal, outward), 0) << "case " << cell_case;
    }
  }
}

// What a cell leaves open on a face, the cell behind that face must leave open the other way round. All 2^12 pairs of
// neighbours, along each axis.
TEST_P(CellTables, NeighboursMeetWithoutGaps) {
  for (int axis = 0; axis < 3; ++axis) {
    const int bit = 1 << axis;
    // The border edges on the high (low) face, by the case of the face; named by edges as seen from the high cell.
    std::map<unsigned, std::set<std::set<std::pair<int, int>>>> high;
    std::map<unsigned, std::set<std::set<std::pair<int, int>>>> low;
    for (unsigned cell_case = 0; cell_case < 256; ++cell_case) {
      for (const bool on_high : {true, false}) {
        const auto on_face = [&](int edge) {
          const CellEdge& e = table_.edges[static_cast<std::size_t>(edge)];
          return (e.direction & bit) == 0 && ((e.corner & bit) != 0) == on_high;
        };
        const auto moved = [&](int edge) {
          CellEdge e = table_.edges[static_cast<std::size_t>(edge)];
          e.corner = static_cast<std::uint8_t>(e.corner & ~bit);
          return static_cast<int>(std::find(table_.edges.begin(), table_.edges.end(), e) - table_.edges.begin());
        };
        unsigned face_case = 0;
        for (unsigned c = 0; c < 8; ++c) {
          if (((c & static_cast<unsigned>(bit)) != 0) == on_high && inside(cell_case, c)) {
            face_case |= 1U << (c & ~static_cast<unsigned>(bit));
          }
        }
        std::set<std::pair<int, int>> open;
        for (const auto& [a, b] : border(cell_case)) {
          if (!on_face(a) || !on_face(b)) continue;
          open.insert(on_high ? std::pair(moved(b), moved(a)) : std::pair(a, b));
        }
        (on_high ? high : low)[face_case].insert(open);
      }
    }
    for (const auto& [face_case, patterns] : high) {
      EXPECT_EQ(patterns.size(), 1U) << "a face's pattern must depend on its own corners alone";
      EXPECT_EQ(patterns, low[face_case]) << "axis " << axis << ", face case " << face_case;
    }
  }
}

TEST_P(CellTables, NothingIsLeftOpenWithinTheCell) {
  for (unsigned cell_case = 0; cell_case < 256; ++cell_case) {
    for (const auto& [a, b] : border(cell_case)) {
      const auto& ea = table_.edges[static_cast<std::size_t>(a)];
      const auto& eb = table_.edges[static_cast<std::size_t>(b)];
      bool on_common_face = false;
      for (int axis = 1; axis < 8; axis <<= 1) {
        on_common_face |= ((ea.direction | eb.direction) & axis) == 0 && (ea.corner & axis) == (eb.corner & axis);
      }
      EXPECT_TRUE(on_common_face) << "case " << cell_case;
    }
  }
}

// If it were, a face's mesh edge and a diagonal of the cell behind it could be the same edge, with four triangles.
TEST_P(CellTables, NoInnerEdgeLiesInAFace) {
  for (unsigned cell_case = 0; cell_case < 256; ++cell_case) {
    const auto open = border(cell_case);
    for (const CellTriangle& t : triangles(cell_case)) {
      for (int c = 0; c < 3; ++c) {
        const int a = t[c];
        const int b = t[(c + 1) % 3];
        if (open.contains({a, b})) continue;
        const auto& ea = table_.edges[static_cast<std::size_t>(a)];
        const auto& eb = table_.edges[static_cast<std::size_t>(b)];
        for (int axis = 1; axis < 8; axis <<= 1) {
          EXPECT_FALSE(((ea.direction | eb.direction) & axis) == 0 && (ea.corner & axis) == (eb.corner & axis))
              << "case " << cell_case;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, CellTables, testing::Values(Method::mc, Method::mt), test::method_name);

TEST(CubesTable, WorkedCaseOne) {
  const CaseTable& table = case_table(Method::mc);
  ASSERT_EQ(table.first[2] - table.first[1], 1);
  const CellTriangle& t = table.triangles[table.first[1]];
  EXPECT_EQ(table.edges[t[0]], (CellEdge{0, 1}));
  EXPECT_EQ(table.edges[t[1]], (CellEdge{0, 2}));
  EXPECT_EQ(table.edges[t[2]], (CellEdge{0, 4}));
}

TEST(CubesTable, HasTheKnownNumberOfTriangles) { EXPECT_EQ(case_table(Method::mc).triangles.size(), 820U); }

// Seed S1's table: opposite cases use the same edges, and the strip's length follows from the number of inside corners.
TEST(TetrahedronCases, AgreeWithTheirCorners) {
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

TEST(CellTetrahedra, FillTheCellWithOneHandedness) {
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
}  // namespace isoextract
