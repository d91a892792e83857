// The meshes of a scene on the device, and drawing them (shaders/render_surfaces.glsl, render_shading.glsl).
#pragma once

#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "render/detail/gpu_buffers.hpp"
#include "render/detail/surface_view.hpp"

namespace isoextract::render::detail {

class GpuSurfaces {
 public:
  // Scene and view outlive this. Fails with ErrorCode::unavailable where the meshes do not fit onto the device.
  [[nodiscard]] static Result<GpuSurfaces> upload(const gl::GlContext& gl, const Scene& scene, const SurfaceView& view,
                                                  GpuMemory& memory, const Context& context);

  [[nodiscard]] bool empty() const { return triangles_ == 0; }
  [[nodiscard]] bool have_opaque() const { return has_opaque_; }
  [[nodiscard]] bool have_see_through() const { return has_see_through_; }

  // For programs that find places of triangles: where they are.
  void bind_triangles(const gl::CellProgram& program) const;
  // Likewise those that shade: what else there is at their corners, and the lights.
  void bind_shading(const gl::CellProgram& program) const;
  // Draws the surfaces that hide what is behind them, or the others.
  [[nodiscard]] Result<void> draw(const gl::GlContext& gl, const gl::CellProgram& program, bool hiding,
                                  const Context& context) const;

 private:
  // As the shader has it (std430).
  struct Record {
    double offset[3];
    std::uint32_t first_triangle;
    std::int32_t vertex_base;
    std::int32_t normal_base;
    std::int32_t colour_base;
    float colour[3];
    float opacity;
  };
  static_assert(sizeof(Record) == 56);

  [[nodiscard]] Result<void> take_arrays(const gl::GlContext& gl, std::uint64_t vertices, std::uint64_t normals,
                                         std::uint64_t colours, GpuMemory& memory);
  void write_colours(const mesh::Attribute& attribute, std::uint64_t first) const;

  const Scene* scene_ = nullptr;
  const SurfaceView* view_ = nullptr;
  std::uint64_t triangles_ = 0;
  bool has_opaque_ = false;
  bool has_see_through_ = false;
  std::vector<Record> records_;
  GpuArray corners_;
  GpuArray positions_;
  GpuArray normals_;
  GpuArray colours_;
  gl::GlBuffer record_buffer_;
};

}  // namespace isoextract::render::detail
