// Finding out before the work whether its results could be written at its end.
#pragma once

#include "base/error.hpp"
#include "cli/plan.hpp"

namespace isoextract {

// The report's file: writable, and neither the input nor a file that the conversion writes besides.
[[nodiscard]] Result<void> check_report_file(const ConvertPlan& plan);

// The meshes' files, or standard output.
[[nodiscard]] Result<void> check_mesh_files(const ConvertPlan& plan);

}  // namespace isoextract
