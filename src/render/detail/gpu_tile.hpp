// The device's buffers for one tile of a picture: the surface buffers that rays read, and the results of rays.
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
  // Makes buffers for tiles of at most `size` pixels. Omits the buffers for surfaces unless `surfaces` is set, and the
  // buffers for transparent surfaces unless `see_through` is set.
  [[nodiscard]] static Result<GpuTile> make(const gl::GlContext& gl, const glm::ivec2& size, bool surfaces,
                                            bool see_through, GpuMemory& memory);

  // Prepares for drawing opaque surfaces: clears depths and triangles, and turns the depth test on.
  void begin_opaque(const PixelBox& box) const;
  // Prepares for drawing transparent surfaces, which only write counts and lists. `at` holds the start of each pixel's
  // list, or zeros if `counting`.
  void begin_lists(const PixelBox& box, bool counting, const std::vector<std::uint32_t>& at) const;
  // Reads the number of fragments of each pixel after a counting pass.
  void read_counts(const PixelBox& box, std::vector<std::uint32_t>& counts) const;
  void begin_rays(const PixelBox& box) const;

  void bind_opaque(const gl::ShaderProgram& program) const;
  // Call this even without lists, because every sampler of a program needs its own texture unit.
  void bind_lists(const gl::ShaderProgram& program) const;

  // Reads the results into the pixels of `box` of the picture. `counts` has one element per pixel. Returns false if the
  // driver cut rays off.
  [[nodiscard]] bool read(const PixelBox& box, Picture& picture, std::vector<glm::uvec4>& counts,
                          RenderStatistics& statistics) const;

  // Bytes per pixel on the device: of the results, the opaque surfaces and the lists.
  static constexpr std::uint64_t kPictureBytes = 16 + 16 + 4 + 16;
  static constexpr std::uint64_t kSurfaceBytes = 4 + 4 + 4;
  static constexpr std::uint64_t kListBytes = 4 + 4;

 private:
  gl::GlTexture opaque_triangles_;
  gl::GlTexture opaque_depths_;
  gl::GlTexture z_buffer_;
  gl::GlTexture list_counts_;
  gl::GlTexture list_ends_;
  gl::GlTexture color_;
  gl::GlTexture normals_;
  gl::GlTexture depths_;
  gl::GlTexture counts_;
  gl::GlFramebuffer surfaces_;
  gl::GlFramebuffer lists_;      // without attachments
  gl::GlFramebuffer list_read_;  // for reading the counts
  gl::GlFramebuffer picture_;
};

}  // namespace isoextract::render::detail
