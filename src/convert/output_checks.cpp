#include "convert/output_checks.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <functional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"
#include "convert/attribute_volumes.hpp"
#include "convert/mesh_pieces.hpp"
#include "convert/particle_source.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"
#include "mesh_io/mesh_reader.hpp"

namespace isoextract::convert {
namespace {

namespace fs = std::filesystem;

// Returns whether this file could be the file of one of the output's bodies.
bool may_be_piece(const fs::path& file, const OutputFileJob& output, mesh_io::MeshFormat format) {
  const auto place = [](const fs::path& path) {
    std::error_code none;
    return fs::weakly_canonical(fs::absolute(path, none), none).string();
  };
  const std::string name = place(file);
  for (const fs::path& pattern : mesh_files(output, format)) {
    const std::string text = place(pattern);
    const std::size_t at = text.find(kPiecePlaceholder);
    if (at == std::string::npos || !name.starts_with(text.substr(0, at))) continue;
    std::size_t number = 0;
    if (std::from_chars(name.data() + at, name.data() + name.size(), number).ec != std::errc()) continue;
    if (number > 0 && piece_path(text, number) == name) return true;
  }
  return false;
}

// Removes or renames an old file, and returns the name to list; empty if the file stays.
using TakeFile = std::function<Result<std::string>(const fs::path&)>;

Result<std::string> remove_file(const fs::path& file) {
  const auto gone = TRY(files::remove_old_file(file));
  return gone ? file.string() : std::string();
}

Result<std::vector<std::string>> take_meshes(const OutputFileJob& output, mesh_io::MeshFormat format,
                                             const Context& context, const TakeFile& take) {
  std::vector<std::string> taken;
  std::vector<std::string> data;
  if (format == mesh_io::MeshFormat::gltf) data = mesh_io::external_buffer_names(output.path, context);
  for (const fs::path& file : mesh_files(output, format)) {
    const bool is_data = file != fs::path(output.path);
    if (is_data && std::ranges::find(data, file.filename().string()) == data.end()) continue;
    auto name = TRY(take(file));
    if (!name.empty()) taken.push_back(std::move(name));
  }
  return taken;
}

Result<std::vector<std::string>> take_pieces(const OutputFileJob& output, std::size_t first, mesh_io::MeshFormat format,
                                             const files::InputFileSet& read, const Context& context,
                                             const TakeFile& take) {
  std::vector<std::string> taken;
  for (std::size_t number = first; number <= kMaxPieceFiles; ++number) {
    const OutputFileJob piece{piece_path(output.path, number), output.isos};
    std::error_code none;
    for (const fs::path& file : mesh_files(piece, format)) {
      if (fs::is_symlink(file, none) || !read.check(file)) return taken;
    }
    if (!mesh_io::is_written_by_isoextract(piece.path, context)) break;
    auto names = take_meshes(piece, format, context, take);
    if (!names) return names;
    taken.insert(taken.end(), names->begin(), names->end());
  }
  return taken;
}

}  // namespace

std::vector<fs::path> mesh_files(const OutputFileJob& output, mesh_io::MeshFormat format) {
  std::vector<fs::path> files{output.path};
  if (format == mesh_io::MeshFormat::gltf) files.push_back(fs::path(output.path).replace_extension(".bin"));
  return files;
}

void add_read_files(files::InputFileSet& read, const ConversionJob& job, const Context& context) {
  const std::string& input = job.source.input;
  read.add(input, "is the input");
  if (job.label_names) read.add(job.label_names->path, "is the table of label names");
  const auto inputs = files::is_standard_input(input)  // has no files beside it
                          ? attribute_files(job.source, context.beside())
                          : list_source_files(job.source, context.beside());
  if (!inputs) return;
  for (const fs::path& file : *inputs) read.add(file, "holds samples or attributes of the input");
}

void add_read_mesh(files::InputFileSet& read, const std::string& path, const Context& context) {
  read.add(path, "is the input");
  if (files::is_standard_input(path)) return;  // only a file can have data files beside it
  const fs::path folder = fs::path(path).parent_path();
  for (const std::string& data : mesh_io::external_buffer_names(path, context.beside())) {
    read.add(folder / data, fmt::format("holds the data of {}", path));
  }
}

// Does not open devices and pipes: opening a pipe twice would end it for its reader.
Result<void> check_output_file(const fs::path& path, const files::InputFileSet& read) {
  TRY(read.check(path));
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status)) return {};
  TRY(files::OutputFile::create(path));
  return {};
}

Result<void> check_extra_output(const fs::path& file, const ConversionJob& job, const Context& context) {
  const mesh_io::MeshFormat format = job.meshes().format;
  for (const OutputFileJob& output : job.outputs) {
    if (may_be_piece(file, output, format)) {
      return fail(
          ErrorCode::usage,
          fmt::format("{}: the report needs a name of its own: the meshes of the bodies of {} may get this name",
                      file.string(), job.source.input),
          {Remedy::change, Setting::output_name});
    }
    for (const fs::path& mesh : mesh_files(output, format)) {
      if (!files::is_same_output(file, mesh)) continue;
      return fail(ErrorCode::usage,
                  fmt::format("{}: the report and {} need different files", file.string(),
                              mesh == "-" ? "the mesh on standard output" : "the mesh"),
                  {Remedy::change, Setting::output_name});
    }
  }
  files::InputFileSet read;
  add_read_files(read, job, context);
  return check_output_file(file, read);
}

std::string first_and_last(const std::vector<std::string>& names) {
  return names.size() < 3 ? fmt::format("{}", fmt::join(names, " and "))
                          : fmt::format("{} to {}", names.front(), names.back());
}

Error with_kept_files(Error error, const std::vector<mesh_io::WrittenFile>& files) {
  if (files.empty() || error.code == ErrorCode::cancelled) return error;
  std::vector<std::string> names;
  for (const mesh_io::WrittenFile& file : files) names.push_back(file.path);
  error.message += fmt::format("; {} written before stay: {}", counted(names.size(), "file"), first_and_last(names));
  return error;
}

Result<std::vector<std::string>> remove_old_meshes(const OutputFileJob& output, mesh_io::MeshFormat format,
                                                   const Context& context) {
  return take_meshes(output, format, context, remove_file);
}

Result<std::vector<std::string>> remove_old_pieces(const OutputFileJob& output, std::size_t first,
                                                   mesh_io::MeshFormat format, const files::InputFileSet& read,
                                                   const Context& context) {
  return take_pieces(output, first, format, read, context, remove_file);
}

Result<std::vector<std::string>> rename_old_meshes(const OutputFileJob& output, mesh_io::MeshFormat format,
                                                   const files::InputFileSet& read,
                                                   std::span<const mesh_io::WrittenFile> spared,
                                                   const Context& context) {
  const auto set_aside = [&](const fs::path& file) -> Result<std::string> {
    const auto is_spared = [&](const mesh_io::WrittenFile& other) { return files::is_same_output(other.path, file); };
    if (!read.check(file) || std::ranges::any_of(spared, is_spared)) return std::string();
    const auto old = TRY(files::rename_old_file(file));
    return old ? old->string() : std::string();
  };
  const bool in_pieces = output.path.find(kPiecePlaceholder) != std::string::npos;
  return in_pieces ? take_pieces(output, 1, format, read, context, set_aside)
                   : take_meshes(output, format, context, set_aside);
}

Result<void> check_mesh_files(const OutputFileJob& output, mesh_io::MeshFormat format,
                              const files::InputFileSet& read) {
  if (output.path == "-") return {};
  for (const fs::path& file : mesh_files(output, format)) {
    TRY(check_output_file(file, read));
  }
  return {};
}

}  // namespace isoextract::convert
