// Checks whether rounding coordinates to the numbers of a file would destroy a mesh that is far from the origin.
//
// A mesh with origin 0 is written as the float32 numbers it consists of: nothing is rounded. For other meshes, the
// coordinates in the file are sums of origin and position. They are float32 in STL and DRC, and double in PLY and OBJ.
// glTF stores both separately, and programs that read it add them; it is checked in double. Rounding moves a coordinate
// by up to half the step between neighboring numbers. Far from 0 this exceeds the width of a triangle: triangles become
// flat, flip or collapse to a point, although their indices still form a closed mesh.
//
// The measure is the damage to triangles, not the distance. For each triangle, take the cross product of two sides
// before and after rounding. The measure is the sum of the lengths of the differences, divided by the sum of the
// lengths before.
// This is about the mean angle, in radians, by which rounding tilts a triangle; it is 1 if all triangles lose their
// area. It grows with rounding relative to the sides of triangles. Slivers, which every isosurface has, count by their
// area, so they weigh little.
// More than 1/4 is refused: for marching cubes, neighboring numbers are then more than about 1/4 of a voxel apart (1/2
// if only one axis is far away), and the steps are visible. For comparison, a scan in millimeters with triangle edges
// of 0.1 at 1000 measures about 1/1000.
//
// glTF also needs a translation within the range of float32, because programs read it as float32.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/error.hpp"
#include "base/note.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::mesh_io {

// Returns how many triangles get two corners at the same coordinates in the file. Fails with ErrorCode::output if
// rounding would destroy the mesh, or if a coordinate or the translation is out of range or the origin is not finite;
// the hint lists the formats that keep the mesh.
// Returns at once for origin 0, visits only the vertices if the file's rounding is no coarser than that of the mesh's
// own numbers, and visits the triangles otherwise.
[[nodiscard]] Result<std::uint64_t> check_coordinate_rounding(const mesh::Mesh& mesh, const std::filesystem::path& path,
                                                              MeshFormat format);

// Tells that `collapsed` of `triangles` get two corners at the same coordinates in the file.
[[nodiscard]] Note rounding_note(const std::filesystem::path& path, std::uint64_t collapsed, std::uint64_t triangles);

}  // namespace isoextract::mesh_io
