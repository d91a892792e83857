// Pictures of meshes that were written to files, all from one camera: for contact sheets and pages.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/placement.hpp"
#include "field/affine.hpp"
#include "render/preview.hpp"

namespace isoextract::cli {

struct WrittenMesh {
  std::string label;               // "12"
  std::vector<std::string> files;  // of one frame; each is read when it is drawn
  std::string_view why_none = {};  // where there are no files, shown in their place: "failed"
};

class MeshPictures {
 public:
  // Reads all files once where there are several meshes, for the box that holds every one. `up` is that of formats
  // which prescribe none. Fails as mesh_io::read_mesh() does.
  [[nodiscard]] static Result<MeshPictures> open(std::vector<WrittenMesh> meshes, const render::PictureSize& size,
                                                 convert::UpAxis up, const Context& context);

  [[nodiscard]] std::size_t count() const { return meshes_.size(); }
  [[nodiscard]] const WrittenMesh& mesh(std::size_t n) const { return meshes_[n]; }
  [[nodiscard]] Result<render::Picture> draw(std::size_t n, const Context& context) const;

 private:
  MeshPictures() = default;

  std::vector<WrittenMesh> meshes_;
  render::PreviewOptions options_;
};

// At most `most` of them, the first and the last among them, evenly spaced.
[[nodiscard]] std::vector<WrittenMesh> some_of(std::vector<WrittenMesh> meshes, std::size_t most);

// The meshes side by side, as a PNG file, whole or not at all.
[[nodiscard]] Result<void> write_contact_sheet(const std::string& path, const MeshPictures& meshes,
                                               const Context& context);

}  // namespace isoextract::cli
