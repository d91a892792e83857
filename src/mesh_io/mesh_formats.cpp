// The mesh formats and their properties.
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::mesh_io {
namespace {

namespace fs = std::filesystem;

constexpr std::array kFormats = {
    MeshFormatInfo{MeshFormat::glb, "glb", "glTF 2.0, one binary file", true, false, true, false, true, false, false,
                   true},
    MeshFormatInfo{MeshFormat::gltf, "gltf", "glTF 2.0, JSON with a .bin beside it", true, true, false, false, true,
                   false, false, true},
    MeshFormatInfo{MeshFormat::ply, "ply", "PLY, binary little-endian or text", false, true, true, true, true, false,
                   false, true},
    MeshFormatInfo{MeshFormat::obj, "obj", "Wavefront OBJ, text", true, true, true, false, false, false, false, true},
    MeshFormatInfo{MeshFormat::stl, "stl", "STL, binary or text", false, true, true, true, false, true, true, true},
    MeshFormatInfo{MeshFormat::drc, "drc", "Draco, compressed", false, true, true, false, true, true, false, false},
};

}  // namespace

bool has_fixed_places(MeshFormat format, bool ascii) {
  return format == MeshFormat::glb || (format == MeshFormat::ply && !ascii);
}

bool is_gltf(MeshFormat format) { return format == MeshFormat::glb || format == MeshFormat::gltf; }

std::span<const MeshFormatInfo> mesh_formats() { return kFormats; }

std::string mesh_extensions() {
  std::string text;
  for (const MeshFormatInfo& info : kFormats) {
    const std::string_view between = &info == &kFormats.front() ? "" : &info == &kFormats.back() ? " or " : ", ";
    text += fmt::format("{}.{}", between, info.name);
  }
  return text;
}

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
  const std::string extension = to_lower(path.extension().string());
  return extension.empty() ? std::nullopt : mesh_format_by_name(std::string_view(extension).substr(1));
}

}  // namespace isoextract::mesh_io
