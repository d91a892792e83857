// A part of a picture on the device: what surfaces leave behind for the rays, and what rays find.
#pragma once

#include <cstdint>
#include <vector>

#include "render/camera.hpp"
#include "render/detail/gpu_buffers.hpp"
#include "render/picture.hpp"
#include "render/renderer.hpp"

namespace isoextract::render::detail {

class GpuTile {
 public:
  // For parts of at most `size` pixels. Without surfaces, or see-through ones, there is no room for them.
  [[nodiscard]] static Result<GpuTile> make(const gl::GlContext& gl, const glm::ivec2& size, bool surfaces,
                                            bool see_through, GpuMemory& memory);

  // What is drawn next are opaque surfaces: depth and triangle are cleared, and the depth test is on.
  void begin_opaque(const PixelBox& box) const;
  // See-through surfaces, which leave no more than their numbers and lists. `at`: where lists begin, or 0 each to count
  // them; `lists` is where list_them() will look.
  void begin_lists(const PixelBox& box, bool counting, const std::vector<std::uint32_t>& at) const;
  // How many fragments each pixel has, once they were counted.
  void read_counts(const PixelBox& box, std::vector<std::uint32_t>& counts) const;
  void begin_rays(const PixelBox& box) const;

  void bind_opaque(const gl::CellProgram& program) const;
  // Also where there is no room for lists: a sampler of a program has a unit of its own, looked at or not.
  void bind_lists(const gl::CellProgram& program) const;

  // Into the pixels of `box`. `counts` has room for four numbers a pixel. False where the driver cut rays off.
  [[nodiscard]] bool read(const PixelBox& box, Picture& picture, std::vector<glm::uvec4>& counts,
                          RenderStatistics& statistics) const;

  // A pixel of it has on the device and in `counts`.
  static constexpr std::uint64_t kPictureBytes = 16 + 16 + 4 + 16;
  static constexpr std::uint64_t kSurfaceBytes = 4 + 4 + 4;
  static constexpr std::uint64_t kListBytes = 4 + 4;

 private:
  gl::GlTexture opaque_triangles_;
  gl::GlTexture opaque_depths_;
  gl::GlTexture z_buffer_;
  gl::GlTexture list_counts_;
  gl::GlTexture list_ends_;
  gl::GlTexture colour_;
  gl::GlTexture normals_;
  gl::GlTexture depths_;
  gl::GlTexture counts_;
  gl::GlFramebuffer surfaces_;
  gl::GlFramebuffer lists_;      // nothing is attached
  gl::GlFramebuffer list_read_;  // the counts, to be read
  gl::GlFramebuffer picture_;
};

}  // namespace isoextract::render::detail
