#include "gpu/detail/field_source.hpp"

#include <fmt/format.h>

namespace isoextract::gpu {

Result<gl::GlTexture> make_sample_texture(const gl::GlContext& context, field::SampleType type,
                                          const glm::ivec3& size) {
  gl::GlTexture texture = gl::GlTexture::make();
  glBindTexture(GL_TEXTURE_3D, texture.name());
  glTexStorage3D(GL_TEXTURE_3D, 1, sample_format(type).internal, size.x, size.y, size.z);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  const glm::u64vec3 wide(size);
  const std::uint64_t bytes = wide.x * wide.y * wide.z * field::sample_size(type);
  TRY(context.check(fmt::format("allocating {} for samples", format_byte_size(bytes))));
  return texture;
}

tl::unexpected<Error> too_little_memory(std::uint64_t bytes, std::uint64_t least) {
  return fail(ErrorCode::usage,
              fmt::format("the GPU memory limit is too small: it leaves {} for samples, expected {} or more",
                          format_byte_size(bytes), format_byte_size(least)),
              {{Remedy::raise, Setting::gpu_memory}, {Remedy::use, Setting::cpu_backend}});
}

}  // namespace isoextract::gpu
