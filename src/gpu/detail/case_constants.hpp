// The CPU's case tables (extract/cell_tables.hpp) in the forms that shaders read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace isoextract::gpu {

// GLSL: `tetrahedron_corners` (six times four corners of the cell) and `tetrahedron_strips` (for each of the 16 cases
// the number of vertices << 16, and four times four bits, the lowest first: the two ends of an edge, as corners of the
// tetrahedron, higher bits first). Strips wind counter-clockwise seen from outside.
[[nodiscard]] std::string tetrahedron_constants();

// Timokhin and Mikhaylyuk's texture of triangle lists: a row of kCaseTexels for each of the 256 cases. First the number
// of triangles | 128 if the case is ambiguous, then the edges of its first variant, three a triangle, as direction << 3
// | corner.
inline constexpr int kCaseTexels = 16;
[[nodiscard]] std::vector<std::uint8_t> cube_case_texels();

}  // namespace isoextract::gpu
