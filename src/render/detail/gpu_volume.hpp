// Uploads a volume to the device as bricks in an atlas (shaders/render_volume.glsl).
#pragma once

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "render/camera.hpp"
#include "render/detail/gpu_buffers.hpp"
#include "render/renderer.hpp"

namespace isoextract::render::detail {

class GpuVolume {
 public:
  // Reads and uploads all visible bricks; with empty-space skipping, sets the brick counts of `statistics`. Fails with
  // ErrorCode::unavailable if the bricks do not fit onto the device or a ray could have too many samples.
  [[nodiscard]] static Result<GpuVolume> upload(const gl::GlContext& gl, const Volume& volume,
                                                const RenderOptions& options, RenderStatistics& statistics,
                                                GpuMemory& memory, const Context& context);

  // Sets all uniforms and textures that the shader needs for the volume as `camera` sees it.
  void bind(const gl::ShaderProgram& program, const Camera& camera) const;

 private:
  [[nodiscard]] Result<void> make_atlas(const gl::GlContext& gl, const std::string& source, std::uint64_t slots,
                                        GpuMemory& memory);

  const Volume* volume_ = nullptr;
  field::Box box_;
  double step_ = 1;
  glm::ivec3 first_node_{0};
  glm::ivec3 slots_{1};  // number of slots along each axis of the atlas
  gl::GlTexture nodes_;
  GpuArray bricks_;
  gl::GlTexture atlas_;
  GpuArray transfer_;
};

}  // namespace isoextract::render::detail
