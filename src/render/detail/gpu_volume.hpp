// A volume on the device: its bricks in an atlas (shaders/render_volume.glsl).
#pragma once

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "render/camera.hpp"
#include "render/detail/gpu_buffers.hpp"
#include "render/renderer.hpp"

namespace isoextract::render::detail {

class GpuVolume {
 public:
  // Reads the samples of all bricks that can be seen, and puts what there is of them into `statistics`. Fails with
  // ErrorCode::unavailable where they do not fit onto the device.
  [[nodiscard]] static Result<GpuVolume> upload(const gl::GlContext& gl, const Volume& volume,
                                                const RenderOptions& options, RenderStatistics& statistics,
                                                GpuMemory& memory, const Context& context);

  // All that the shader asks of the volume itself, and of how the camera sees it.
  void bind(const gl::CellProgram& program, const Camera& camera) const;

 private:
  [[nodiscard]] Result<void> make_atlas(const gl::GlContext& gl, const std::string& source, std::uint64_t slots,
                                        GpuMemory& memory);

  const Volume* volume_ = nullptr;
  field::Box box_;
  double step_ = 1;
  glm::ivec3 first_node_{0};
  glm::ivec3 slots_{1};  // of the atlas along each axis
  gl::GlTexture nodes_;
  GpuArray bricks_;
  gl::GlTexture atlas_;
  GpuArray transfer_;
};

}  // namespace isoextract::render::detail
