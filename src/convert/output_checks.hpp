// Finding out before the work whether its results could be written at its end.
#pragma once

#include <filesystem>
#include <string>

#include "base/error.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::convert {

// Another file that goes with the job, its report for example: writable, and neither the input nor a mesh of the job.
[[nodiscard]] Result<void> check_other_file(const std::filesystem::path& file, const ConversionJob& job);

// The meshes' files, standard output apart.
[[nodiscard]] Result<void> check_mesh_files(const ConversionJob& job);

// A file that is written at the end: writable, and not the input.
[[nodiscard]] Result<void> check_output_file(const std::filesystem::path& path, const std::string& input);

// Whether two paths name one file, whether it exists or not.
[[nodiscard]] bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace isoextract::convert
