// Uploads a volume to the device as bricks in an atlas (shaders/render_volume.glsl).
#pragma once

#include <memory>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "render/camera.hpp"
#include "render/detail/gpu_buffers.hpp"
#include "render/renderer.hpp"

namespace isoextract::render::detail {

class GpuVolume {
 public:
  // Reads and uploads all visible bricks of the volume and its emission; with empty-space skipping, sets the brick
  // counts of `statistics`. Fails with ErrorCode::unavailable if the bricks do not fit onto the device or a ray could
  // have too many samples.
  [[nodiscard]] static Result<GpuVolume> upload(const gl::GlContext& gl, const Volume& volume,
                                                const RenderOptions& options, RenderStatistics& statistics,
                                                GpuMemory& memory, const Context& context);

  // Sets all uniforms and textures that the shader needs for the volume and its emission as `camera` sees them.
  void bind(const gl::ShaderProgram& program, const Camera& camera) const;

  [[nodiscard]] bool has_emission() const { return emission_ != nullptr; }

 private:
  // The names in shaders/render_volume.glsl.
  struct Names;

  // Uploads the field of `volume`, without its emission.
  [[nodiscard]] static Result<GpuVolume> upload_field(const gl::GlContext& gl, const Volume& volume,
                                                      const RenderOptions& options, RenderStatistics& statistics,
                                                      GpuMemory& memory, const Context& context);
  void bind_field(const gl::ShaderProgram& program, const Camera& camera, const Names& names) const;
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
  std::unique_ptr<GpuVolume> emission_;
};

}  // namespace isoextract::render::detail
