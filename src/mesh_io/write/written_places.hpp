// What the numbers of a file do to a mesh that is far from the origin of its coordinates.
//
// A mesh without an origin of its own is written as the float32 numbers that it consists of: nothing is rounded. Of one
// with an origin, the coordinates in the file are sums: in float32 in STL and DRC, in double in PLY and OBJ, and in
// double for whoever reads glTF, which keeps the two apart. Rounding moves each vertex by up to half the distance of
// such numbers there. Far enough away that is more than a triangle is wide: the surface becomes a heap of triangles
// that are flat, turned over or at one place, although their indices still make a closed mesh.
//
// The measure is what happens to the triangles, not how far away they are: of the vectors that stand on them, as long
// as their area (the cross products of their sides), the sum of the changes, as a fraction of the sum of the lengths.
// That is about the angle, in radians, by which rounding turns a triangle on the average, and 1 where all lose their
// area. It grows as the rounding does in relation to the sides of triangles, and slivers, of which every isosurface has
// some, weigh as little as they are seen. More than a quarter is refused: there, coordinates are about a fifth of a
// voxel apart, and what one sees is their lattice. A scan in millimetres with triangles of 0.1 at 1000 is at a
// thousandth.
//
// glTF needs a translation that float32 holds besides, for that is what programs read it into.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/error.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::mesh_io {

// How many triangles have two corners at one place in the file, which they have not in the mesh. Fails with
// ErrorCode::output and Remedy::place_nearer. Costs nothing where the mesh has no origin, a look at the
// vertices where rounding is less than that of the mesh's own numbers, and a look at the triangles otherwise.
[[nodiscard]] Result<std::uint64_t> check_places(const mesh::Mesh& mesh, const std::filesystem::path& path,
                                                 MeshFormat format);

}  // namespace isoextract::mesh_io
