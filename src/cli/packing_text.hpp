// How packing is told.
#pragma once

#include <string>

#include "convert/mesh_packing.hpp"

namespace isoextract::cli {

// The line that every run with packed meshes shows, and what --explain adds.
[[nodiscard]] std::string packing_summary(const convert::MeshPackingRecord& record);
[[nodiscard]] std::string packing_details(const convert::MeshPackingRecord& record);

}  // namespace isoextract::cli
