#include "render/detail/gpu_buffers.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace isoextract::render::detail {

Result<GpuArray> GpuArray::make(const gl::GlContext& context, GLenum format, std::uint64_t count,
                                std::uint64_t element_bytes, const std::string& what, GpuMemory& memory) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  if (count > static_cast<std::uint64_t>(most)) {
    return fail(ErrorCode::unavailable,
                fmt::format("{}: {}: expected at most {} elements in a GPU buffer, found {}", context.device().renderer,
                            what, most, count),
                {Remedy::use, Setting::cpu_backend});
  }
  GpuArray array;
  array.element_bytes_ = element_bytes;
  const std::uint64_t bytes =
      std::max<std::uint64_t>(count, 1) * element_bytes;  // a texture needs at least one element
  TRY(memory.take(bytes, what));
  array.buffer_ = gl::GlBuffer::make();
  array.texture_ = gl::GlTexture::make();
  glBindBuffer(GL_TEXTURE_BUFFER, array.buffer_.name());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_STATIC_DRAW);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_BUFFER, array.texture_.name());
  glTexBuffer(GL_TEXTURE_BUFFER, format, array.buffer_.name());
  TRY(context.check(fmt::format("allocating memory for {}", what)));
  return array;
}

void GpuArray::write(std::uint64_t first, std::uint64_t count, const void* elements) const {
  if (count == 0) return;
  glBindBuffer(GL_TEXTURE_BUFFER, buffer_.name());
  glBufferSubData(GL_TEXTURE_BUFFER, static_cast<GLintptr>(first * element_bytes_),
                  static_cast<GLsizeiptr>(count * element_bytes_), elements);
}

}  // namespace isoextract::render::detail
