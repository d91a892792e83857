// How the error of a mesh is told.
#pragma once

#include <string>
#include <vector>

#include "convert/mesh_error.hpp"

namespace isoextract::cli {

// The lines that every run with --error shows: the distance, and what could not be measured.
[[nodiscard]] std::vector<std::string> error_summary(const convert::MeshError& error);
// What --explain adds: vertices, storage, what was left out.
[[nodiscard]] std::vector<std::string> error_details(const convert::MeshError& error);

}  // namespace isoextract::cli
