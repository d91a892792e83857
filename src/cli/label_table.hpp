// Formats the table of a written file's labels. --verbose prints the table.
#pragma once

#include <string>
#include <vector>

#include "convert/stage_report.hpp"

namespace isoextract::cli {

// Returns a line of headings and a line for each mesh of a label: label, number of voxels, volume of the voxels in the
// units of the mesh, triangles, whether the mesh is closed, name. `output` has surfaces of labels only.
[[nodiscard]] std::vector<std::string> label_table(const convert::WrittenOutput& output);

}  // namespace isoextract::cli
