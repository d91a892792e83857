// The shader constants agree with the case tables, and the tables have the properties that the GPU code assumes.
#include "gpu/detail/case_constants.hpp"

#include <algorithm>
#include <array>
#include <regex>
#include <set>

#include <gtest/gtest.h>

#include "extract/cell_tables.hpp"
#include "extract/edge_geometry.hpp"

namespace isoextract::gpu {
namespace {

std::vector<int> numbers_of(const std::string& text, const std::string& name) {
  std::smatch found;
  if (!std::regex_search(text, found, std::regex(name + R"(\[(\d+)\] = int\[\]\(([-0-9, ]*)\);)"))) return {};
  std::vector<int> numbers;
  const std::string list = found[2];
  for (std::size_t at = 0; at < list.size(); at = list.find_first_of(',', at)) {
    if (list[at] == ',') ++at;
    numbers.push_back(std::stoi(list.substr(at)));
  }
  EXPECT_EQ(std::to_string(numbers.size()), found[1]);
  return numbers;
}

// Three cell edges, each as direction << 3 | corner.
using EdgeTriangle = std::array<int, 3>;

EdgeTriangle from_least(EdgeTriangle triangle) {
  std::ranges::rotate(triangle, std::ranges::min_element(triangle));
  return triangle;
}

std::multiset<EdgeTriangle> table_triangles(const extract::CaseTable& table, unsigned variant) {
  std::multiset<EdgeTriangle> set;
  for (int t = table.first[variant]; t < table.first[variant + 1]; ++t) {
    EdgeTriangle triangle{};
    for (std::size_t v = 0; v < 3; ++v) {
      const extract::CellEdge& edge = table.edges[table.triangles[static_cast<std::size_t>(t)][v]];
      triangle[v] = edge.direction << 3 | edge.corner;
    }
    set.insert(from_least(triangle));
  }
  return set;
}

// Reads the constants as mt_geometry.geom does: for all 256 cases, the six tetrahedra draw the triangles of the cell.
TEST(TetrahedronConstants, EqualCaseTable) {
  const std::string text = tetrahedron_constants();
  const auto corners = numbers_of(text, "tetrahedron_corners");
  const auto strips = numbers_of(text, "tetrahedron_strips");
  ASSERT_EQ(corners.size(), 24U);
  ASSERT_EQ(strips.size(), 16U);
  const extract::CaseTable& table = extract::case_table(extract::Method::mt);
  for (unsigned cell_case = 0; cell_case < 256; ++cell_case) {
    std::multiset<EdgeTriangle> drawn;
    for (std::size_t tetrahedron = 0; tetrahedron < 6; ++tetrahedron) {
      const int* corner = corners.data() + 4 * tetrahedron;
      unsigned index = 0;
      for (int c = 0; c < 4; ++c) index = index << 1 | (cell_case >> corner[c] & 1);
      if (index == 0 || index == 15) continue;
      const int strip = strips[index];
      const auto edge = [&](int v) {
        const int ends = strip >> (4 * v) & 15;
        const int a = corner[ends >> 2];
        const int b = corner[ends & 3];
        return (a ^ b) << 3 | (a & b);
      };
      const int count = strip >> 16;
      EXPECT_TRUE(count == 3 || count == 4);
      drawn.insert(from_least({edge(0), edge(1), edge(2)}));
      if (count == 4) drawn.insert(from_least({edge(2), edge(1), edge(3)}));
    }
    EXPECT_EQ(drawn, table_triangles(table, table.variants[cell_case])) << cell_case;
  }
}

// mt_geometry.geom finds the cell from the ends of its diagonal.
TEST(TetrahedronConstants, StartAndEndAtDiagonal) {
  for (const auto& tetrahedron : extract::cell_tetrahedra()) {
    EXPECT_EQ(std::min(tetrahedron[0], tetrahedron[3]), 0);
    EXPECT_EQ(std::max(tetrahedron[0], tetrahedron[3]), 7);
  }
}

TEST(CubeCaseTexels, HoldFirstVariantOfEveryCase) {
  const auto texels = cube_case_texels();
  ASSERT_EQ(texels.size(), 256U * kCaseTexels);
  const extract::CaseTable& table = extract::case_table(extract::Method::mc);
  int most = 0;
  for (unsigned cell_case = 0; cell_case < 256; ++cell_case) {
    const std::uint8_t* row = texels.data() + std::size_t{cell_case} * kCaseTexels;
    const int count = row[0] & 127;
    most = std::max(most, count);
    EXPECT_EQ(row[0] >> 7 != 0, table.ambiguous[cell_case]);
    std::multiset<EdgeTriangle> drawn;
    std::set<int> edges;
    for (int t = 0; t < count; ++t) {
      const std::uint8_t* at = row + 1 + 3 * t;
      drawn.insert(from_least({at[0], at[1], at[2]}));
      edges.insert(at, at + 3);
    }
    EXPECT_EQ(drawn, table_triangles(table, table.variants[cell_case])) << cell_case;
    for (int rest = 1 + 3 * count; rest < kCaseTexels; ++rest) EXPECT_EQ(row[rest], 0);
    // The first variant has every vertex that any variant may need.
    std::set<int> crossed;
    for (const extract::CellEdge& edge : table.edges) {
      const bool in0 = (cell_case >> edge.corner & 1) != 0;
      const bool in1 = (cell_case >> (edge.corner | edge.direction) & 1) != 0;
      if (in0 != in1) crossed.insert(edge.direction << 3 | edge.corner);
    }
    EXPECT_EQ(edges, crossed) << cell_case;
  }
  EXPECT_EQ(most, 5) << "max_vertices of mc.geom";
}

// site_weld.cpp takes the minimum of the lower ends of a triangle's edges as its cell.
TEST(CaseTables, TouchLowSideOfCell) {
  for (const extract::Method method : {extract::Method::mc, extract::Method::mt}) {
    const extract::CaseTable& table = extract::case_table(method);
    for (const extract::CellTriangle& triangle : table.triangles) {
      unsigned shared = 7;
      for (const std::uint8_t edge : triangle) shared &= table.edges[edge].corner;
      EXPECT_EQ(shared, 0U);
    }
  }
}

}  // namespace
}  // namespace isoextract::gpu
