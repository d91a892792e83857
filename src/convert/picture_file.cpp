#include "convert/picture_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/output_file.hpp"
#include "image_io/png_writer.hpp"
#include "render/preview.hpp"
#include "render/renderer.hpp"

namespace isoextract::convert {

namespace {

bool is_vertex_color(const mesh::Attribute& attribute) {
  return attribute.role == mesh::AttributeRole::color && attribute.components >= 3;
}

}  // namespace

render::Surface surface_of(const mesh::Mesh& mesh) {
  render::Surface surface;
  surface.mesh = &mesh;
  if (mesh.material) {
    surface.color = mesh.material->color.value_or(surface.color);
    surface.opacity = mesh.material->opacity;
  }
  surface.shading = mesh.normals.empty() ? render::Shading::flat : render::Shading::smooth;
  surface.vertex_colors = std::ranges::any_of(mesh.attributes, is_vertex_color);
  return surface;
}

Result<void> color_by_materials(mesh_io::MeshFile& file, const Context& context) {
  const auto has_material = [](const mesh_io::MeshPart& part) { return part.material.has_value(); };
  if (std::ranges::none_of(file.parts, has_material)) return {};
  mesh::Mesh& mesh = file.mesh;
  const auto is_color = [](const mesh::Attribute& attribute) { return is_vertex_color(attribute); };
  const auto old = std::ranges::find_if(mesh.attributes, is_color);
  const mesh::Attribute* const own = old != mesh.attributes.end() ? &*old : nullptr;
  const bool sees_through =
      (own != nullptr && own->components > 3) || std::ranges::any_of(file.parts, [](const mesh_io::MeshPart& part) {
        return part.material && part.material->opacity < 1;
      });
  mesh::Attribute made{"color", mesh::AttributeRole::color, mesh::ComponentType::f32, sees_through ? 4U : 3U, false,
                       {}};
  const std::size_t vertices = mesh.positions.size();
  auto memory = TRY(context.reserve(vertices * made.stride(), mesh.name + ": the colors of its materials"));
  made.values = Buffer<std::byte>(vertices * made.stride());
  const glm::dvec3 usual = render::Surface().color;
  for (const mesh_io::MeshPart& part : file.parts) {
    const mesh::Material look = part.material.value_or(mesh::Material());
    const glm::dvec4 factor(look.color.value_or(own != nullptr ? glm::dvec3(1) : usual), look.opacity);
    for (std::uint64_t v = part.first_vertex; v < part.first_vertex + part.vertices; ++v) {
      const glm::vec4 color(factor * (own != nullptr ? render::vertex_color(*own, v) : glm::dvec4(1)));
      std::memcpy(made.values.data() + v * made.stride(), &color, made.stride());
    }
  }
  if (own != nullptr) mesh.attributes.erase(old);
  mesh.attributes.push_back(std::move(made));
  mesh.memory.take(std::move(memory));
  return {};
}

render::UpAxis render_up_axis(UpAxis up) { return up == UpAxis::y ? render::UpAxis::y : render::UpAxis::z; }

render::PreviewOptions preview_of(const PictureFileOptions& picture, UpAxis up, double front) {
  const auto side = [](std::int64_t pixels) {  // keeps sizes out of range, which draw_preview() rejects
    return static_cast<int>(std::clamp<std::int64_t>(pixels, 0, PictureFileOptions::kMaxSide + 1));
  };
  render::PreviewOptions options;
  options.size = {side(picture.width), side(picture.height)};
  options.angles = picture.angles;
  options.angles.front = front;
  options.fovy = picture.fovy;
  options.background = picture.background;
  options.up = render_up_axis(up);
  return options;
}

image_io::LightImage light_of(const render::Picture& picture) {
  return {picture.width, picture.height, picture.color.span(), picture.depth.span(), picture.normals.span()};
}

Result<std::uint64_t> write_png(const std::string& path, const render::Picture& picture, const Context& context) {
  auto file = TRY(files::OutputFile::create(path));
  TRY(image_io::write_png(file, light_of(picture), context));
  const std::uint64_t bytes = file.bytes_written();
  TRY(file.commit());
  return bytes;
}

Result<WrittenPicture> write_picture(std::span<const mesh::Mesh> meshes, const PictureFileOptions& picture,
                                     const Placement& placement, double front, const OutputFileJob& output,
                                     const Context& context) {
  std::vector<render::Surface> surfaces;
  for (const mesh::Mesh& mesh : meshes) surfaces.push_back(surface_of(mesh));
  render::PreviewOptions options = preview_of(picture, placement.up, front);
  if (!placement.unit.empty()) options.unit = placement.to_unit;
  const auto renderer = render::make_cpu_renderer();
  auto drawn = TRY(render::draw_preview(surfaces, options, *renderer, context));
  const auto bytes = TRY(write_png(output.path, drawn.picture, context));
  WrittenPicture done{{{{output.path, bytes}}, {}, {}}, false};
  const auto is_there = [](const mesh::Mesh& mesh) { return !mesh.triangles.empty(); };
  const auto is_seen = [](float depth) { return std::isfinite(depth); };
  done.misses_surfaces = std::ranges::any_of(meshes, is_there) && std::ranges::none_of(drawn.picture.depth, is_seen);
  if (done.misses_surfaces) {
    done.written.notes.push_back(
        {NoteId::empty_picture, fmt::format("{}: the picture is empty: no part of the surfaces is in the camera's view",
                                            printable(output.path))});
  }
  return done;
}

}  // namespace isoextract::convert
