// The table of the labels in a written file, which --verbose prints.
#pragma once

#include <string>
#include <vector>

#include "convert/stage_report.hpp"

namespace isoextract::cli {

// Returns a line for the headings and one for each mesh of a label: label, voxels, their volume in the units of the
// mesh, triangles, whether the mesh is closed, and its name. `output` has surfaces of labels only.
[[nodiscard]] std::vector<std::string> label_table(const convert::WrittenOutput& output);

}  // namespace isoextract::cli
