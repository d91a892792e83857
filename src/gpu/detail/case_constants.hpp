// The case tables of the CPU (extract/cell_tables.hpp) in the forms that shaders read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace isoextract::gpu {

// Returns GLSL constants. `tetrahedron_corners`: six times four corners of the cell. `tetrahedron_strips`: for each of
// the 16 cases, the number of vertices << 16, and four groups of four bits, the lowest first. A group holds the two
// ends of an edge as corners of the tetrahedron, in its upper and lower two bits. Strips wind counter-clockwise seen
// from outside.
[[nodiscard]] std::string tetrahedron_constants();

// Returns Timokhin and Mikhaylyuk's texture of triangle lists: a row of kCaseTexels for each of the 256 cases. A row
// starts with the number of triangles, | 128 if the case is ambiguous. Then come the edges of the first variant, three
// a triangle, as direction << 3 | corner.
inline constexpr int kCaseTexels = 16;
[[nodiscard]] std::vector<std::uint8_t> cube_case_texels();

}  // namespace isoextract::gpu
