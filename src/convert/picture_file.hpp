// The stage that draws the surfaces into a picture instead of writing meshes.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "image_io/light_image.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "render/picture.hpp"
#include "render/preview.hpp"
#include "render/scene.hpp"

namespace isoextract::convert {

// Returns how to draw a mesh: with its material, its vertex colors, and its normals if it has them. Keeps a pointer to
// `mesh`.
[[nodiscard]] render::Surface surface_of(const mesh::Mesh& mesh);

// Gives the vertices of a file with several meshes the colors and opacities of their materials, multiplied by the
// vertices' own colors, as glTF prescribes. Does nothing if no mesh has a material. Fails with ErrorCode::out_of_memory
// if memory is short.
[[nodiscard]] Result<void> color_by_materials(mesh_io::MeshFile& file, const Context& context);

[[nodiscard]] render::UpAxis render_up_axis(UpAxis up);

// Returns how to draw a picture in which the axis `up` points up and the front is at the azimuth `front` in degrees.
[[nodiscard]] render::PreviewOptions preview_of(const PictureFileOptions& picture, UpAxis up, double front);

// Returns an image that refers to the memory of `picture`.
[[nodiscard]] image_io::LightImage light_of(const render::Picture& picture);

// Writes a PNG file, completely or not at all, and returns its size in bytes. Fails as image_io::write_png() does, and
// with ErrorCode::output.
[[nodiscard]] Result<std::uint64_t> write_png(const std::string& path, const render::Picture& picture,
                                              const Context& context);

struct WrittenPicture {
  mesh_io::MeshWriteResult written;
  bool misses_surfaces = false;  // there are surfaces, but the camera sees none of them
};

// Draws `meshes`, placed by `placement` and with the front at the azimuth `front` in degrees, on the CPU and writes the
// picture to `output`, completely or not at all. The picture is the same for any number of threads. Adds a note if the
// picture shows none of the surfaces. Fails as render::draw_preview() and write_png() do.
[[nodiscard]] Result<WrittenPicture> write_picture(std::span<const mesh::Mesh> meshes,
                                                   const PictureFileOptions& picture, const Placement& placement,
                                                   double front, const OutputFileJob& output, const Context& context);

}  // namespace isoextract::convert
