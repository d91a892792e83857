// Finding out before the work whether its results could be written at its end.
#pragma once

#include <filesystem>
#include <string>

#include "base/error.hpp"
#include "cli/plan.hpp"

namespace isoextract::cli {

// The report's file: writable, and neither the input nor a file that the conversion writes besides.
[[nodiscard]] Result<void> check_report_file(const ConvertPlan& plan);

// The meshes' files, or standard output.
[[nodiscard]] Result<void> check_mesh_files(const ConvertPlan& plan);

// A file that is written at the end: writable, and not the input.
[[nodiscard]] Result<void> check_output_file(const std::filesystem::path& path, const std::string& input);

// Whether two paths name one file, whether it exists or not.
[[nodiscard]] bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace isoextract::cli
