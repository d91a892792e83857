#include "meshes/mesh_writer.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "meshes/write/mesh_format_writers.hpp"

namespace isoextract::meshes {
namespace {

namespace fs = std::filesystem;

constexpr std::array kFormats = {
    MeshFormatInfo{MeshFormat::glb, "glb", "glTF 2.0, one binary file", true, true, false, true},
    MeshFormatInfo{MeshFormat::gltf, "gltf", "glTF 2.0, JSON with a .bin beside it", true, false, false, true},
    MeshFormatInfo{MeshFormat::ply, "ply", "PLY, binary little-endian or text", false, true, true, true},
    MeshFormatInfo{MeshFormat::obj, "obj", "Wavefront OBJ, text", true, true, false, false},
    MeshFormatInfo{MeshFormat::stl, "stl", "STL, binary or text", false, true, true, false},
};

std::string names_of_formats(bool MeshFormatInfo::*property) {
  std::string names;
  for (const MeshFormatInfo& info : kFormats) {
    if (info.*property) names += fmt::format("{}{}", names.empty() ? "" : ", ", info.name);
  }
  return names;
}

Result<void> check(std::span<const mesh::Mesh> meshes, const fs::path& path, const MeshWriteOptions& options) {
  const MeshFormatInfo& info = mesh_format_info(options.format);
  if (options.ascii && !info.has_ascii) {
    return fail(ErrorKind::usage, fmt::format("{}: the format {} cannot be text", path.string(), info.name),
                {Remedy::ascii_formats, names_of_formats(&MeshFormatInfo::has_ascii)});
  }
  if (meshes.size() != 1 && !info.holds_several_meshes) {
    return fail(ErrorKind::usage,
                fmt::format("{}: the format {} holds one mesh, found {}", path.string(), info.name, meshes.size()),
                {Remedy::one_file_per_surface, names_of_formats(&MeshFormatInfo::holds_several_meshes)});
  }
  if (info.can_stream) return {};
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (path == "-" || (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))) {
    return fail(
        ErrorKind::usage,
        fmt::format("{}: the format {} makes two files and cannot be written to a stream", path.string(), info.name),
        {Remedy::choose_mesh_format, names_of_formats(&MeshFormatInfo::can_stream)});
  }
  if (path.extension() == ".bin") {
    return fail(ErrorKind::usage,
                fmt::format("{}: the data of the format {} would get this name as well", path.string(), info.name),
                "use a name that ends in .gltf");
  }
  return {};
}

// For formats without attributes.
void note_attributes(std::span<const mesh::Mesh> meshes, const MeshFormatInfo& info, Notes& notes) {
  std::vector<std::string> names;
  for (const mesh::Mesh& mesh : meshes) {
    for (const mesh::Attribute& attribute : mesh.attributes) {
      std::string name = fmt::format("'{}'", attribute.name);
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(std::move(name));
    }
  }
  if (names.empty()) return;
  notes.push_back(fmt::format("{} has no attributes of vertices: {} left out; {} keep them", info.name,
                              fmt::format("{} {}", fmt::join(names, ", "), names.size() == 1 ? "was" : "were"),
                              names_of_formats(&MeshFormatInfo::has_attributes)));
}

Result<void> write_one_file(std::span<const mesh::Mesh> meshes, const MeshWriteOptions& options,
                            files::OutputFile& file, Notes& notes) {
  const MeshFormatInfo& info = mesh_format_info(options.format);
  if (!info.has_attributes) note_attributes(meshes, info, notes);
  switch (options.format) {
    case MeshFormat::ply: return write_ply(meshes[0], options, file, notes);
    case MeshFormat::obj: return write_obj(meshes, options, file);
    case MeshFormat::stl: return write_stl(meshes[0], options, file, notes);
    case MeshFormat::glb:
    case MeshFormat::gltf: break;
  }
  return write_glb(meshes, options, file, notes);
}

Result<MeshWriteResult> write_file(std::span<const mesh::Mesh> meshes, const fs::path& path,
                                   const MeshWriteOptions& options) {
  auto file = files::OutputFile::create(path);
  if (!file) return tl::unexpected<Error>(std::move(file.error()));
  MeshWriteResult result;
  auto done = write_one_file(meshes, options, *file, result.notes);
  if (done) done = file->commit();
  if (!done) return tl::unexpected<Error>(std::move(done.error()));
  result.files.push_back({path.string(), file->bytes_written()});
  return result;
}

Result<MeshWriteResult> write_pair(std::span<const mesh::Mesh> meshes, const fs::path& path,
                                   const MeshWriteOptions& options) {
  fs::path binary_path = path;
  binary_path.replace_extension(".bin");
  auto model = files::OutputFile::create(path);
  if (!model) return tl::unexpected<Error>(std::move(model.error()));
  auto binary = files::OutputFile::create(binary_path);
  if (!binary) return tl::unexpected<Error>(std::move(binary.error()));
  MeshWriteResult result;
  auto done = write_gltf(meshes, options, *model, *binary, binary_path.filename().string(), result.notes);
  const bool has_binary = done && binary->bytes_written() > 0;
  if (done) done = has_binary ? files::OutputFile::commit_pair(*binary, *model) : model->commit();
  if (!done) return tl::unexpected<Error>(std::move(done.error()));
  result.files.push_back({path.string(), model->bytes_written()});
  if (has_binary) result.files.push_back({binary_path.string(), binary->bytes_written()});
  return result;
}

}  // namespace

std::span<const MeshFormatInfo> mesh_formats() { return kFormats; }

const MeshFormatInfo& mesh_format_info(MeshFormat format) {
  return *std::find_if(kFormats.begin(), kFormats.end(),
                       [format](const MeshFormatInfo& info) { return info.format == format; });
}

std::optional<MeshFormat> mesh_format_by_name(std::string_view name) {
  for (const MeshFormatInfo& info : kFormats) {
    if (info.name == name) return info.format;
  }
  return std::nullopt;
}

std::optional<MeshFormat> mesh_format_by_path(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension.empty() ? std::nullopt : mesh_format_by_name(std::string_view(extension).substr(1));
}

Result<MeshWriteResult> write_meshes(std::span<const mesh::Mesh> meshes, const fs::path& path,
                                     const MeshWriteOptions& options, const Context& context) {
  try {
    if (auto going_on = context.check(); !going_on) return tl::unexpected<Error>(std::move(going_on.error()));
    if (auto possible = check(meshes, path, options); !possible) {
      return tl::unexpected<Error>(std::move(possible.error()));
    }
    return options.format == MeshFormat::gltf ? write_pair(meshes, path, options) : write_file(meshes, path, options);
  } catch (const std::exception& error) {  // out of memory, or a library's own
    return fail(ErrorKind::output, fmt::format("{}: cannot write: {}", path.string(), error.what()));
  }
}

}  // namespace isoextract::meshes
