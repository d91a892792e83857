#include "cli/output_checks.hpp"

#include <filesystem>

#include <fmt/format.h>
#include <unistd.h>

#include "files/output_file.hpp"
#include "volumes/volume_reader.hpp"

namespace isoextract::cli {
namespace {

namespace fs = std::filesystem;

// The files that a job writes: glTF is two.
std::vector<fs::path> files_of(const OutputJob& job, meshes::MeshFormat format) {
  std::vector<fs::path> files{job.path};
  if (format == meshes::MeshFormat::gltf) files.push_back(fs::path(job.path).replace_extension(".bin"));
  return files;
}

Result<void> check_stdout(const meshes::MeshWriteOptions& options) {
  const bool is_text = options.ascii || options.format == meshes::MeshFormat::obj;
  if (is_text || ::isatty(STDOUT_FILENO) == 0) return {};
  return fail(ErrorKind::usage,
              fmt::format("stdout is a terminal, and {} is binary data", meshes::mesh_format_info(options.format).name),
              "redirect it to a file or a pipe");
}

// Where the input's header is a file of its own, those that hold the samples. What cannot be told is an error when the
// input is read.
Result<void> check_data_files(const fs::path& output, const ConvertPlan& plan) {
  const auto inputs = volumes::list_input_files(plan.input, plan.read);
  if (!inputs) return {};
  for (const fs::path& input : *inputs) {
    std::error_code none;
    if (!fs::equivalent(output, input, none)) continue;
    return fail(ErrorKind::usage,
                fmt::format("{}: this holds the samples of the input; it is not overwritten", output.string()),
                "choose another name with -o");
  }
  return {};
}

}  // namespace

// Devices and pipes are left alone: opening a pipe twice would end it for its reader.
Result<void> check_output_file(const fs::path& path, const std::string& input) {
  std::error_code none;
  if (fs::equivalent(path, input, none)) {
    return fail(ErrorKind::usage, fmt::format("{}: this is the input; it is not overwritten", path.string()),
                "choose another name with -o");
  }
  const fs::file_status status = fs::status(path, none);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status)) return {};
  auto probe = files::OutputFile::create(path);
  if (!probe) return tl::unexpected(probe.error());
  return {};
}

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code none;
  if (fs::equivalent(a, b, none)) return true;
  return fs::weakly_canonical(fs::absolute(a, none), none) == fs::weakly_canonical(fs::absolute(b, none), none);
}

Result<void> check_report_file(const ConvertPlan& plan) {
  const fs::path report(*plan.report);
  for (const OutputJob& job : plan.jobs) {
    if (job.path == "-") continue;
    for (const fs::path& file : files_of(job, plan.write.format)) {
      if (!same_file(report, file)) continue;
      return fail(ErrorKind::usage, fmt::format("{}: this is the mesh as well as the report", report.string()),
                  "choose another name with --report");
    }
  }
  auto checked = check_output_file(report, plan.input);
  if (checked) checked = check_data_files(report, plan);
  if (!checked && checked.error().kind == ErrorKind::usage) checked.error().hint = "choose another name with --report";
  return checked;
}

Result<void> check_mesh_files(const ConvertPlan& plan) {
  for (const OutputJob& job : plan.jobs) {
    if (job.path == "-") {
      if (auto checked = check_stdout(plan.write); !checked) return checked;
      continue;
    }
    for (const fs::path& file : files_of(job, plan.write.format)) {
      if (auto checked = check_output_file(file, plan.input); !checked) return checked;
      if (auto checked = check_data_files(file, plan); !checked) return checked;
    }
  }
  return {};
}

}  // namespace isoextract::cli
