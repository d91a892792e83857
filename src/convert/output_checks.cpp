#include "convert/output_checks.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "convert/mesh_pieces.hpp"
#include "convert/particle_source.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"
#include "meshes/mesh_reader.hpp"

namespace isoextract::convert {
namespace {

namespace fs = std::filesystem;

// Whether a piece of an output could be this file.
bool may_be_piece(const fs::path& file, const OutputFileJob& output, meshes::MeshFormat format) {
  const auto place = [](const fs::path& path) {
    std::error_code none;
    return fs::weakly_canonical(fs::absolute(path, none), none).string();
  };
  const std::string name = place(file);
  for (const fs::path& pattern : mesh_files(output, format)) {
    const std::string text = place(pattern);
    const std::size_t at = text.find(kPieceWord);
    if (at == std::string::npos || !name.starts_with(text.substr(0, at))) continue;
    std::size_t number = 0;
    if (std::from_chars(name.data() + at, name.data() + name.size(), number).ec != std::errc()) continue;
    if (number > 0 && piece_path(text, number) == name) return true;
  }
  return false;
}

}  // namespace

std::vector<fs::path> mesh_files(const OutputFileJob& output, meshes::MeshFormat format) {
  std::vector<fs::path> files{output.path};
  if (format == meshes::MeshFormat::gltf) files.push_back(fs::path(output.path).replace_extension(".bin"));
  return files;
}

void add_read_files(files::ReadFiles& read, const ConversionJob& job) {
  const std::string& input = job.source.input;
  read.add(input, "is the input");
  if (job.label_names) read.add(job.label_names->path, "has the names of labels");
  if (files::is_standard_input(input)) return;  // all is in it
  const auto inputs = list_source_files(job.source);
  if (!inputs) return;
  for (const fs::path& file : *inputs) read.add(file, "holds the samples of the input");
}

void add_read_mesh(files::ReadFiles& read, const std::string& path, const Context& context) {
  read.add(path, "is the input");
  if (files::is_standard_input(path)) return;  // data files lie beside a file
  const fs::path folder = fs::path(path).parent_path();
  for (const std::string& data : meshes::data_file_names(path, context)) {
    read.add(folder / data, fmt::format("holds the data of {}", path));
  }
}

// Devices and pipes are left alone: opening a pipe twice would end it for its reader.
Result<void> check_output_file(const fs::path& path, const files::ReadFiles& read) {
  if (auto checked = read.check(path); !checked) return checked;
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status)) return {};
  auto probe = files::OutputFile::create(path);
  if (!probe) return tl::unexpected(probe.error());
  return {};
}

Result<void> check_other_file(const fs::path& file, const ConversionJob& job) {
  for (const OutputFileJob& output : job.outputs) {
    if (may_be_piece(file, output, job.format)) {
      return fail(ErrorKind::usage,
                  fmt::format("{}: a piece of {} may have this name", file.string(), job.source.input),
                  Remedy::other_output_name);
    }
    for (const fs::path& mesh : mesh_files(output, job.format)) {
      if (!files::same_place(file, mesh)) continue;
      return fail(ErrorKind::usage,
                  fmt::format("{}: this is {} as well as the report", file.string(),
                              mesh == "-" ? "standard output, where the mesh goes," : "the mesh"),
                  Remedy::other_output_name);
    }
  }
  files::ReadFiles read;
  add_read_files(read, job);
  return check_output_file(file, read);
}

std::string first_and_last(const std::vector<std::string>& names) {
  return names.size() < 3 ? fmt::format("{}", fmt::join(names, " and "))
                          : fmt::format("{} to {}", names.front(), names.back());
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
                                                   meshes::MeshFormat format, const files::ReadFiles& read,
                                                   const Context& context) {
  std::vector<std::string> removed;
  for (std::size_t number = first; number <= kMostPieceFiles; ++number) {
    const OutputFileJob piece{piece_path(output.path, number), output.isos};
    std::error_code none;
    for (const fs::path& file : mesh_files(piece, format)) {
      if (fs::is_symlink(file, none) || !read.check(file)) return removed;
    }
    if (!meshes::is_signed(piece.path, context)) break;
    auto gone = remove_old_meshes(piece, format, context);
    if (!gone) return gone;
    if (gone->empty()) break;
    removed.insert(removed.end(), gone->begin(), gone->end());
  }
  return removed;
}

Result<void> check_mesh_files(const OutputFileJob& output, meshes::MeshFormat format, const files::ReadFiles& read) {
  if (output.path == "-") return {};
  for (const fs::path& file : mesh_files(output, format)) {
    if (auto checked = check_output_file(file, read); !checked) return checked;
  }
  return {};
}

}  // namespace isoextract::convert
