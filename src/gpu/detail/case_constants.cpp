#include "gpu/detail/case_constants.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "extract/cell_tables.hpp"

namespace isoextract::gpu {

std::string tetrahedron_constants() {
  std::vector<int> corners;
  for (const auto& tetrahedron : extract::cell_tetrahedra())
    corners.insert(corners.end(), tetrahedron.begin(), tetrahedron.end());
  std::vector<int> strips;
  for (const extract::TetrahedronCase& drawn : extract::tetrahedron_cases()) {
    // The strips of the paper wind clockwise seen from outside. Swapping the second and third vertex reverses a strip
    // (cell_tables.cpp reverses its triangles).
    constexpr std::array<std::size_t, 4> kOrder{0, 2, 1, 3};
    int packed = (drawn.quad ? 4 : 3) << 16;
    for (std::size_t v = 0; v < kOrder.size(); ++v) {
      const auto& ends = drawn.strip[kOrder[v]];
      packed |= (ends[0] << 2 | ends[1]) << (4 * v);
    }
    strips.push_back(packed);
  }
  return fmt::format("const int tetrahedron_corners[24] = int[]({});\nconst int tetrahedron_strips[16] = int[]({});\n",
                     fmt::join(corners, ", "), fmt::join(strips, ", "));
}

std::vector<std::uint8_t> cube_case_texels() {
  const extract::CaseTable& table = extract::case_table(extract::Method::mc);
  std::vector<std::uint8_t> texels(256 * kCaseTexels);
  for (std::size_t cell_case = 0; cell_case < 256; ++cell_case) {
    std::uint8_t* row = texels.data() + cell_case * kCaseTexels;
    const std::size_t variant = table.variants[cell_case];
    const int count = table.first[variant + 1] - table.first[variant];
    row[0] = static_cast<std::uint8_t>(count | (table.ambiguous[cell_case] ? 128 : 0));
    for (int t = 0; t < count; ++t) {
      const extract::CellTriangle& triangle = table.triangles[table.first[variant] + t];
      for (const std::uint8_t edge : triangle) {
        *++row = static_cast<std::uint8_t>(table.edges[edge].direction << 3 | table.edges[edge].corner);
      }
    }
  }
  return texels;
}

}  // namespace isoextract::gpu
