// Distinguishes VTK's unstructured grids of cells, which are volumes, from grids of points, which are particles.
#pragma once

#include <string_view>

#include "files/file_bytes.hpp"

namespace isoextract::particle_io {

// Returns whether an unstructured grid of VTK has cells other than points. `start` is the start of the file. Looks at
// the first cell's type in legacy files, and at the numbers of points and cells in XML. False if the file does not
// tell.
[[nodiscard]] bool has_vtk_cells(const files::InputFile& file, std::string_view start);

}  // namespace isoextract::particle_io
