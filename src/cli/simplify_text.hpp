// How simplification is told.
#pragma once

#include <string>

#include "convert/mesh_simplify.hpp"

namespace isoextract::cli {

// The line that every run with --simplify shows, and what --explain adds.
[[nodiscard]] std::string simplification_summary(const convert::MeshSimplification& simplification,
                                                 std::string_view word);
[[nodiscard]] std::string simplification_details(const convert::MeshSimplification& simplification);

}  // namespace isoextract::cli
