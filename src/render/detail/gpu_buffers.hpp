// Arrays that shaders read by index.
#pragma once

#include <epoxy/gl.h>

#include <cstdint>
#include <string>

#include "gl/gl_context.hpp"
#include "gl/gl_object.hpp"
#include "gl/gl_program.hpp"
#include "render/detail/gpu_memory.hpp"

namespace isoextract::render::detail {

// Texture units, the same in all programs of the renderer.
enum class TextureUnit {
  triangle_corners,
  vertex_positions,
  vertex_normals,
  vertex_colors,
  opaque_triangles,
  opaque_depths,
  list_counts,
  list_ends,
  nodes,
  bricks,
  atlas,
  transfer,
  emission_nodes,
  emission_bricks,
  emission_atlas,
  emission_transfer  // the last of the 16 units that every device has
};

inline void bind_texture(const gl::ShaderProgram& program, const char* name, TextureUnit unit, GLenum target,
                         const gl::GlTexture& texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture.name());
  program.set(name, static_cast<int>(unit));
}

// An array in a buffer texture.
class GpuArray {
 public:
  GpuArray() = default;
  // Makes an array of `count` elements; `what` names the elements in messages. Fails with ErrorCode::unavailable if a
  // texture cannot have that many elements, and as GpuMemory::take() and GlContext::check() do.
  [[nodiscard]] static Result<GpuArray> make(const gl::GlContext& context, GLenum format, std::uint64_t count,
                                             std::uint64_t element_bytes, const std::string& what, GpuMemory& memory);

  void write(std::uint64_t first, std::uint64_t count, const void* elements) const;
  void bind(const gl::ShaderProgram& program, const char* name, TextureUnit unit) const {
    bind_texture(program, name, unit, GL_TEXTURE_BUFFER, texture_);
  }

 private:
  gl::GlBuffer buffer_;
  gl::GlTexture texture_;
  std::uint64_t element_bytes_ = 0;
};

}  // namespace isoextract::render::detail
