#include "render/detail/gpu_tile.hpp"

#include <array>
#include <limits>
#include <utility>

namespace isoextract::render::detail {
namespace {

constexpr std::uint32_t kCutOff = 2;  // same value as in shaders/render_rays.frag

gl::GlTexture make_image(GLenum format, const glm::ivec2& size) {
  gl::GlTexture texture = gl::GlTexture::make();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glTexStorage2D(GL_TEXTURE_2D, 1, format, size.x, size.y);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

void attach(GLenum where, const gl::GlTexture& texture) {
  glFramebufferTexture2D(GL_FRAMEBUFFER, where, GL_TEXTURE_2D, texture.name(), 0);
}

glm::ivec2 size_of(const PixelBox& box) { return box.max - box.min; }

void begin(const gl::GlFramebuffer& target, const PixelBox& box) {
  glBindFramebuffer(GL_FRAMEBUFFER, target.name());
  const glm::ivec2 size = size_of(box);
  glViewport(0, 0, size.x, size.y);
  glDisable(GL_SCISSOR_TEST);
}

}  // namespace

Result<GpuTile> GpuTile::make(const gl::GlContext& gl, const glm::ivec2& size, bool surfaces, bool see_through,
                              GpuMemory& memory) {
  const auto pixels = static_cast<std::uint64_t>(size.x) * static_cast<std::uint64_t>(size.y);
  const std::uint64_t bytes =
      kPictureBytes + (surfaces ? kSurfaceBytes : 0) + (see_through ? kListBytes : std::uint64_t{0});
  TRY(memory.take(pixels * bytes, "a tile of a picture"));
  GpuTile tile;
  constexpr std::array<GLenum, 4> kTargets{GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2,
                                           GL_COLOR_ATTACHMENT3};
  if (surfaces) {
    tile.opaque_triangles_ = make_image(GL_R32UI, size);
    tile.opaque_depths_ = make_image(GL_R32F, size);
    tile.z_buffer_ = make_image(GL_DEPTH_COMPONENT32F, size);
    tile.surfaces_ = gl::GlFramebuffer::make();
    glBindFramebuffer(GL_FRAMEBUFFER, tile.surfaces_.name());
    attach(GL_COLOR_ATTACHMENT0, tile.opaque_triangles_);
    attach(GL_COLOR_ATTACHMENT1, tile.opaque_depths_);
    attach(GL_DEPTH_ATTACHMENT, tile.z_buffer_);
    glDrawBuffers(2, kTargets.data());
  }
  if (see_through) {
    tile.list_counts_ = make_image(GL_R32UI, size);
    tile.list_ends_ = make_image(GL_R32UI, size);
    tile.lists_ = gl::GlFramebuffer::make();
    glBindFramebuffer(GL_FRAMEBUFFER, tile.lists_.name());
    glFramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_WIDTH, size.x);
    glFramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_HEIGHT, size.y);
    tile.list_read_ = gl::GlFramebuffer::make();
    glBindFramebuffer(GL_FRAMEBUFFER, tile.list_read_.name());
    attach(GL_COLOR_ATTACHMENT0, tile.list_counts_);
  }
  tile.color_ = make_image(GL_RGBA32F, size);
  tile.normals_ = make_image(GL_RGBA32F, size);
  tile.depths_ = make_image(GL_R32F, size);
  tile.counts_ = make_image(GL_RGBA32UI, size);
  tile.picture_ = gl::GlFramebuffer::make();
  glBindFramebuffer(GL_FRAMEBUFFER, tile.picture_.name());
  attach(GL_COLOR_ATTACHMENT0, tile.color_);
  attach(GL_COLOR_ATTACHMENT1, tile.normals_);
  attach(GL_COLOR_ATTACHMENT2, tile.depths_);
  attach(GL_COLOR_ATTACHMENT3, tile.counts_);
  glDrawBuffers(4, kTargets.data());
  TRY(gl.check("allocating memory for a tile of a picture"));
  return tile;
}

void GpuTile::begin_opaque(const PixelBox& box) const {
  begin(surfaces_, box);
  constexpr std::array<GLuint, 4> kNone{std::numeric_limits<GLuint>::max(), 0, 0, 0};
  constexpr std::array<GLfloat, 4> kNever{std::numeric_limits<GLfloat>::infinity(), 0, 0, 0};
  constexpr GLfloat kFar = 1;
  glDepthMask(GL_TRUE);
  glClearBufferuiv(GL_COLOR, 0, kNone.data());
  glClearBufferfv(GL_COLOR, 1, kNever.data());
  glClearBufferfv(GL_DEPTH, 0, &kFar);
  glEnable(GL_DEPTH_TEST);
  // At equal depth the first triangle stays, which has the lower number.
  glDepthFunc(GL_LESS);
}

void GpuTile::begin_lists(const PixelBox& box, bool counting, const std::vector<std::uint32_t>& at) const {
  const gl::GlTexture& places = counting ? list_counts_ : list_ends_;
  const glm::ivec2 size = size_of(box);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, places.name());
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size.x, size.y, GL_RED_INTEGER, GL_UNSIGNED_INT, at.data());
  glBindImageTexture(0, places.name(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
  begin(lists_, box);
  glDisable(GL_DEPTH_TEST);
}

void GpuTile::read_counts(const PixelBox& box, std::vector<std::uint32_t>& counts) const {
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  const glm::ivec2 size = size_of(box);
  glBindFramebuffer(GL_FRAMEBUFFER, list_read_.name());
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glReadPixels(0, 0, size.x, size.y, GL_RED_INTEGER, GL_UNSIGNED_INT, counts.data());
}

void GpuTile::begin_rays(const PixelBox& box) const {
  begin(picture_, box);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_SCISSOR_TEST);
}

void GpuTile::bind_opaque(const gl::ShaderProgram& program) const {
  bind_texture(program, "opaque_triangles", TextureUnit::opaque_triangles, GL_TEXTURE_2D, opaque_triangles_);
  bind_texture(program, "opaque_depths", TextureUnit::opaque_depths, GL_TEXTURE_2D, opaque_depths_);
}

void GpuTile::bind_lists(const gl::ShaderProgram& program) const {
  bind_texture(program, "list_counts", TextureUnit::list_counts, GL_TEXTURE_2D, list_counts_);
  bind_texture(program, "list_ends", TextureUnit::list_ends, GL_TEXTURE_2D, list_ends_);
}

bool GpuTile::read(const PixelBox& box, Picture& picture, std::vector<glm::uvec4>& counts,
                   RenderStatistics& statistics) const {
  const glm::ivec2 size = size_of(box);
  const std::size_t first = static_cast<std::size_t>(box.min.x) +
                            static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(box.min.y);
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  const auto read_pixels = [&](GLenum attachment, GLenum format, GLenum type, void* to) {
    glReadBuffer(attachment);
    glReadPixels(0, 0, size.x, size.y, format, type, to);
  };
  glPixelStorei(GL_PACK_ROW_LENGTH, picture.width);
  read_pixels(GL_COLOR_ATTACHMENT0, GL_RGBA, GL_FLOAT, picture.color.data() + first);
  read_pixels(GL_COLOR_ATTACHMENT1, GL_RGB, GL_FLOAT, picture.normals.data() + first);
  read_pixels(GL_COLOR_ATTACHMENT2, GL_RED, GL_FLOAT, picture.depth.data() + first);
  glPixelStorei(GL_PACK_ROW_LENGTH, 0);
  read_pixels(GL_COLOR_ATTACHMENT3, GL_RGBA_INTEGER, GL_UNSIGNED_INT, counts.data());
  const std::size_t pixels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  bool whole = true;
  for (std::size_t p = 0; p < pixels; ++p) {
    whole = whole && (counts[p].x & kCutOff) == 0;
    statistics.rays += counts[p].x & ~kCutOff;
    statistics.samples += counts[p].y;
    statistics.samples_skipped += counts[p].z;
    statistics.samples_terminated += counts[p].w;
  }
  return whole;
}

}  // namespace isoextract::render::detail
