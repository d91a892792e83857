#include "convert/output_checks.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "convert/mesh_pieces.hpp"
#include "convert/particle_source.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"
#include "meshes/mesh_reader.hpp"

namespace isoextract::convert {
namespace {

namespace fs = std::filesystem;

// Where the input's header is a file of its own, those that hold the samples. What cannot be told is an error when the
// input is read.
Result<void> check_data_files(const fs::path& output, const ConversionJob& job) {
  if (files::is_standard_input(job.source.input)) return {};  // all is in it
  const auto inputs = list_source_files(job.source);
  if (!inputs) return {};
  for (const fs::path& input : *inputs) {
    std::error_code none;
    if (!fs::equivalent(output, input, none)) continue;
    return fail(ErrorKind::usage,
                fmt::format("{}: this holds the samples of the input; it is not overwritten", output.string()),
                Remedy::other_output_name);
  }
  return {};
}

}  // namespace

std::vector<fs::path> mesh_files(const OutputFileJob& output, meshes::MeshFormat format) {
  std::vector<fs::path> files{output.path};
  if (format == meshes::MeshFormat::gltf) files.push_back(fs::path(output.path).replace_extension(".bin"));
  return files;
}

// Devices and pipes are left alone: opening a pipe twice would end it for its reader.
Result<void> check_output_file(const fs::path& path, const std::string& input) {
  std::error_code none;
  const fs::path source = files::is_standard_input(input) ? fs::path("/dev/stdin") : fs::path(input);
  if (fs::equivalent(path, source, none)) {
    return fail(ErrorKind::usage, fmt::format("{}: this is the input; it is not overwritten", path.string()),
                Remedy::other_output_name);
  }
  const fs::file_status status = fs::status(path, none);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status)) return {};
  auto probe = files::OutputFile::create(path);
  if (!probe) return tl::unexpected(probe.error());
  return {};
}

Result<void> check_other_file(const fs::path& file, const ConversionJob& job) {
  for (const OutputFileJob& output : job.outputs) {
    for (const fs::path& mesh : mesh_files(output, job.format)) {
      if (!files::same_place(file, mesh)) continue;
      return fail(ErrorKind::usage,
                  fmt::format("{}: this is {} as well as the report", file.string(),
                              mesh == "-" ? "standard output, where the mesh goes," : "the mesh"),
                  Remedy::other_output_name);
    }
  }
  auto checked = check_output_file(file, job.source.input);
  return checked ? check_data_files(file, job) : checked;
}

Result<std::vector<std::string>> remove_old_meshes(const OutputFileJob& output, meshes::MeshFormat format,
                                                   const Context& context) {
  std::vector<std::string> removed;
  std::vector<std::string> data;
  if (format == meshes::MeshFormat::gltf) data = meshes::data_file_names(output.path, context);
  for (const fs::path& file : mesh_files(output, format)) {
    const bool is_data = file != fs::path(output.path);
    if (is_data && std::ranges::find(data, file.filename().string()) == data.end()) continue;
    auto gone = files::remove_old_file(file);
    if (!gone) return tl::unexpected(std::move(gone.error()));
    if (*gone) removed.push_back(file.string());
  }
  return removed;
}

Result<std::vector<std::string>> remove_old_pieces(const OutputFileJob& output, std::size_t first,
                                                   const ConversionJob& job, const Context& context) {
  std::vector<std::string> removed;
  for (std::size_t number = first; number <= kMostPieceFiles; ++number) {
    const OutputFileJob piece{piece_path(output.path, number), output.isos};
    std::error_code none;
    for (const fs::path& file : mesh_files(piece, job.format)) {
      if (fs::equivalent(file, job.source.input, none) || !check_data_files(file, job)) return removed;
    }
    if (!meshes::is_signed(piece.path, context)) break;
    auto gone = remove_old_meshes(piece, job.format, context);
    if (!gone) return gone;
    if (gone->empty()) break;
    removed.insert(removed.end(), gone->begin(), gone->end());
  }
  return removed;
}

Result<void> check_mesh_files(const ConversionJob& job) {
  for (const OutputFileJob& output : job.outputs) {
    if (output.path == "-") continue;
    for (const fs::path& file : mesh_files(output, job.format)) {
      if (auto checked = check_output_file(file, job.source.input); !checked) return checked;
      if (auto checked = check_data_files(file, job); !checked) return checked;
    }
  }
  return {};
}

}  // namespace isoextract::convert
