// The stage that draws the surfaces, in place of writing them as meshes.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "image_io/light_image.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "render/picture.hpp"
#include "render/scene.hpp"

namespace isoextract::convert {

// How a picture shows a mesh: by its material, its vertices' colours, and its normals where it has some. The mesh is
// lent.
[[nodiscard]] render::Surface surface_of(const mesh::Mesh& mesh);

[[nodiscard]] render::UpAxis shown_up(UpAxis up);

// The picture is lent.
[[nodiscard]] image_io::LightImage light_of(const render::Picture& picture);

// Whole or not at all; gives the bytes of the file. Fails as image_io::write_png() does, and with ErrorCode::output.
[[nodiscard]] Result<std::uint64_t> write_png(const std::string& path, const render::Picture& picture,
                                              const Context& context);

struct WrittenPicture {
  mesh_io::MeshWriteResult written;
  bool misses_surfaces = false;  // there are some, and the camera sees none of them
};

// Draws `meshes`, which are placed so, on the processor, the same picture for any number of threads, and writes it to
// `output`, whole or not at all. A note tells where it misses all surfaces. Fails as render::draw_preview() does, and
// with ErrorCode::output.
[[nodiscard]] Result<WrittenPicture> write_picture(std::span<const mesh::Mesh> meshes,
                                                   const PictureFileOptions& picture, const Placement& placement,
                                                   const OutputFileJob& output, const Context& context);

}  // namespace isoextract::convert
