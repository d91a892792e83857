#include "convert/picture_file.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/output_file.hpp"
#include "image_io/png_writer.hpp"
#include "render/preview.hpp"
#include "render/renderer.hpp"

namespace isoextract::convert {

render::Surface surface_of(const mesh::Mesh& mesh) {
  render::Surface surface;
  surface.mesh = &mesh;
  if (mesh.material) {
    surface.color = mesh.material->color.value_or(surface.color);
    surface.opacity = mesh.material->opacity;
  }
  surface.shading = mesh.normals.empty() ? render::Shading::flat : render::Shading::smooth;
  surface.vertex_colors = std::ranges::any_of(mesh.attributes, [](const mesh::Attribute& attribute) {
    return attribute.role == mesh::AttributeRole::color && attribute.components >= 3;
  });
  return surface;
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
