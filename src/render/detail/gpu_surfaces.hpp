// Uploads the meshes of a scene to the device and draws them (shaders/render_surfaces.glsl, render_shading.glsl).
#pragma once

#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "render/detail/gpu_buffers.hpp"
#include "render/detail/surface_view.hpp"

namespace isoextract::render::detail {

class GpuSurfaces {
 public:
  // `scene` and `view` must outlive this object. Fails with ErrorCode::unavailable if the meshes do not fit onto the
  // device.
  [[nodiscard]] static Result<GpuSurfaces> upload(const gl::GlContext& gl, const Scene& scene, const SurfaceView& view,
                                                  GpuMemory& memory, const Context& context);

  [[nodiscard]] bool empty() const { return triangles_ == 0; }
  [[nodiscard]] bool has_opaque_triangles() const { return has_opaque_; }
  [[nodiscard]] bool has_transparent_triangles() const { return has_see_through_; }

  // Binds the positions of triangles, for programs that compute where triangles are.
  void bind_triangles(const gl::ShaderProgram& program) const;
  // Binds normals, colors and lights, for programs that shade.
  void bind_shading(const gl::ShaderProgram& program) const;
  // Draws the opaque surfaces if `hiding`, otherwise the transparent ones.
  [[nodiscard]] Result<void> draw(const gl::GlContext& gl, const gl::ShaderProgram& program, bool hiding,
                                  const Context& context) const;

 private:
  // Layout as in the shader (std430).
  struct Record {
    double offset[3];
    std::uint32_t first_triangle;
    std::int32_t vertex_base;
    std::int32_t normal_base;
    std::int32_t color_base;
    float color[3];
    float opacity;
  };
  static_assert(sizeof(Record) == 56);

  [[nodiscard]] Result<void> take_arrays(const gl::GlContext& gl, std::uint64_t vertices, std::uint64_t normals,
                                         std::uint64_t colors, GpuMemory& memory);
  void write_colors(const mesh::Attribute& attribute, std::uint64_t first) const;

  const Scene* scene_ = nullptr;
  const SurfaceView* view_ = nullptr;
  std::uint64_t triangles_ = 0;
  bool has_opaque_ = false;
  bool has_see_through_ = false;
  std::vector<Record> records_;
  GpuArray corners_;
  GpuArray positions_;
  GpuArray normals_;
  GpuArray colors_;
  gl::GlBuffer record_buffer_;
};

}  // namespace isoextract::render::detail
