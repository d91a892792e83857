#include "cli/mesh_pictures.hpp"

#include <algorithm>
#include <utility>

#include "convert/picture_file.hpp"
#include "mesh/metrics.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "render/contact_sheet.hpp"
#include "render/picture_text.hpp"
#include "render/renderer.hpp"
#include "render/surface_normals.hpp"

namespace isoextract::cli {

Result<MeshPictures> MeshPictures::open(std::vector<WrittenMesh> meshes, render::PreviewOptions options,
                                        const Context& context) {
  MeshPictures pictures;
  pictures.options_ = std::move(options);
  std::optional<field::Box>& box = pictures.options_.box;
  for (const WrittenMesh& written : meshes) {
    if (meshes.size() == 1) break;  // a single mesh is framed by its own box
    for (const std::string& file : written.files) {
      auto read = TRY(mesh_io::read_mesh(file, context));
      if (read.mesh.triangles.empty()) continue;
      const mesh::Bounds own = mesh::measure_bounds(read.mesh);
      box = box ? field::Box{glm::min(box->min, own.min), glm::max(box->max, own.max)} : field::Box{own.min, own.max};
    }
    TRY(context.check());
  }
  pictures.meshes_ = std::move(meshes);
  return pictures;
}

Result<render::Picture> MeshPictures::draw(std::size_t n, const Context& context) const {
  render::PreviewOptions options = options_;
  std::vector<mesh_io::MeshFile> files;
  for (const std::string& file : meshes_[n].files) {
    auto read = TRY(mesh_io::read_mesh(file, context, {.scene = true}));
    if (read.y_up) options.up = render::UpAxis::y;
    TRY(convert::color_by_materials(read, context));
    TRY(render::add_normals(read.mesh, file, context));
    files.push_back(std::move(read));
  }
  std::vector<render::Surface> surfaces;
  for (const mesh_io::MeshFile& file : files) surfaces.push_back(convert::surface_of(file.mesh));
  const auto renderer = render::make_cpu_renderer();
  auto drawn = TRY(render::draw_preview(surfaces, options, *renderer, context));
  render::Picture& picture = drawn.picture;
  const int dot = std::max(1, picture.height / 120);
  const glm::ivec2 size = render::text_size(meshes_[n].text_if_empty, dot);
  render::draw_text(picture, {(picture.width - size.x) / 2, (picture.height - size.y) / 2}, meshes_[n].text_if_empty,
                    dot, render::text_color(options.background));
  return std::move(picture);
}

std::vector<WrittenMesh> evenly_spaced(std::vector<WrittenMesh> meshes, std::size_t most) {
  if (meshes.size() <= most) return meshes;
  std::vector<WrittenMesh> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(std::move(meshes[i * (meshes.size() - 1) / (most - 1)]));
  return some;
}

Result<void> write_contact_sheet(const std::string& path, const MeshPictures& meshes, const Context& context) {
  std::optional<render::ContactSheet> sheet;
  for (std::size_t n = 0; n < meshes.count(); ++n) {
    auto picture = TRY(meshes.draw(n, context));
    if (!sheet) {
      sheet = TRY(render::ContactSheet::create({picture.width, picture.height}, meshes.count(), context));
    }
    sheet->place(n, picture, meshes.mesh(n).label);
  }
  const auto written = convert::write_png(path, sheet->picture(), context);
  return written ? Result<void>() : tl::unexpected(written.error());
}

}  // namespace isoextract::cli
