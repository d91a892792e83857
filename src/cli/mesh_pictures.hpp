// Draws meshes from files, several with one camera, for contact sheets and pages.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "render/preview.hpp"

namespace isoextract::cli {

struct WrittenMesh {
  std::string label;                    // "12"
  std::vector<std::string> files;       // of one frame; drawn together
  std::string_view text_if_empty = {};  // drawn in the middle of the picture; set it if there are no files: "failed"
};

class MeshPictures {
 public:
  // Reads all files once if there are several meshes, and extends the box of `options` to contain the meshes. Reads
  // nothing for a single mesh. The up axis of `options` is for formats that prescribe none. Fails as
  // mesh_io::read_mesh() and Context::check() do.
  [[nodiscard]] static Result<MeshPictures> open(std::vector<WrittenMesh> meshes, render::PreviewOptions options,
                                                 const Context& context);

  [[nodiscard]] std::size_t count() const { return meshes_.size(); }
  [[nodiscard]] const WrittenMesh& mesh(std::size_t n) const { return meshes_[n]; }
  // Reads the files of mesh n and draws them on the CPU. Fails as mesh_io::read_mesh(), render::add_normals() and
  // render::draw_preview() do.
  [[nodiscard]] Result<render::Picture> draw(std::size_t n, const Context& context) const;

 private:
  MeshPictures() = default;

  std::vector<WrittenMesh> meshes_;
  render::PreviewOptions options_;
};

// Returns at most `most` evenly spaced meshes, including the first and the last. `most` is at least 2.
[[nodiscard]] std::vector<WrittenMesh> evenly_spaced(std::vector<WrittenMesh> meshes, std::size_t most);

// Writes a PNG file with all meshes, row by row; leaves no partial file on failure. Requires at least one mesh. Fails
// as MeshPictures::draw(), render::ContactSheet::create() and convert::write_png() do.
[[nodiscard]] Result<void> write_contact_sheet(const std::string& path, const MeshPictures& meshes,
                                               const Context& context);

}  // namespace isoextract::cli
