// Layout of binary STL: a header of free text, then the number of triangles.
#pragma once

#include <cstddef>

namespace isoextract::mesh_io {

constexpr std::size_t kStlHeaderBytes = 80;

}  // namespace isoextract::mesh_io
