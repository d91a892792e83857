#include "render/detail/gpu_picture.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "render/detail/volume_pixels.hpp"

namespace isoextract::render::detail {
namespace {

constexpr int kStripPixels = 1 << 17;  // rays per draw call; cancellation is checked in between
constexpr std::uint64_t kFragmentBytes = 8;

std::size_t pixels_in(const PixelBox& box) {
  const glm::ivec2 size = box.max - box.min;
  return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
}

PixelBox common_of(const PixelBox& a, const PixelBox& b) {
  const PixelBox both{glm::max(a.min, b.min), glm::min(a.max, b.max)};
  return both.empty() ? PixelBox{} : both;
}

// Returns `box` without `inner`, which lies in it: the parts above, below, left and right, which may be empty.
std::array<PixelBox, 4> around(const PixelBox& box, const PixelBox& inner) {
  if (inner.empty()) return {box, PixelBox{}, PixelBox{}, PixelBox{}};
  return {PixelBox{box.min, {box.max.x, inner.min.y}}, PixelBox{{box.min.x, inner.max.y}, box.max},
          PixelBox{{box.min.x, inner.min.y}, {inner.min.x, inner.max.y}},
          PixelBox{{inner.max.x, inner.min.y}, {box.max.x, inner.max.y}}};
}

// Splits the box along its longer side.
std::array<PixelBox, 2> halves(const PixelBox& box) {
  const glm::ivec2 size = box.max - box.min;
  PixelBox a = box;
  PixelBox b = box;
  if (size.x > size.y) {
    a.max.x = b.min.x = box.min.x + size.x / 2;
  } else {
    a.max.y = b.min.y = box.min.y + size.y / 2;
  }
  return {a, b};
}

gl::ProgramSource source_of(GpuPrograms::Name name) {
  using Name = GpuPrograms::Name;
  gl::ProgramSource source;
  if (name == Name::opaque || name == Name::see_through) {
    if (name == Name::opaque) source.defines.emplace_back("OPAQUE");
    source.stages = {{GL_VERTEX_SHADER, {"render_surfaces.glsl", "render_surface.vert"}},
                     {GL_FRAGMENT_SHADER, {"render_surfaces.glsl", "render_surface.frag"}}};
    return source;
  }
  std::vector<std::string_view> parts{"render_surfaces.glsl"};
  const bool emission = name == Name::rays_emission || name == Name::rays_both_emission;
  if (name == Name::rays_surfaces || name == Name::rays_both || name == Name::rays_both_emission) {
    source.defines.emplace_back("SURFACES");
    parts.emplace_back("render_shading.glsl");
  }
  if (name == Name::rays_volume || name == Name::rays_both || emission) {
    source.defines.emplace_back("VOLUME");
    if (emission) source.defines.emplace_back("EMISSION");
    source.constants = fmt::format("const int kEntries = {};\n", TransferFunction::kEntries);
    parts.emplace_back("render_volume.glsl");
  }
  if (emission) parts.insert(parts.end(), {"render_emission_names.glsl", "render_volume.glsl", "render_emission.glsl"});
  parts.emplace_back("render_rays.frag");
  source.stages = {{GL_VERTEX_SHADER, {"render_rays.vert"}}, {GL_FRAGMENT_SHADER, std::move(parts)}};
  return source;
}

}  // namespace

Result<const gl::ShaderProgram*> GpuPrograms::get(const gl::GlContext& gl, Name name) {
  auto& program = programs_[static_cast<std::size_t>(name)];
  if (!program) {
    program = TRY(gl::ShaderProgram::link(gl, source_of(name)));
  }
  return &*program;
}

Result<GpuPicture> GpuPicture::make(const GpuTask& task, GpuMemory& memory) {
  GpuPicture picture(task, memory);
  GLint side = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
  GLint viewport[2] = {};
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  const PictureSize& size = task.options.size;
  const int width = std::min({size.width, side, viewport[0], kTilePixels});
  picture.tile_size_ = {width, std::min({size.height, side, viewport[1], std::max(1, kTilePixels / width)})};
  const bool see_through = task.surfaces.has_transparent_triangles();
  auto targets = TRY(GpuTile::make(task.gl, picture.tile_size_, !task.surfaces.empty(), see_through, memory));
  picture.targets_.emplace(std::move(targets));

  const std::size_t pixels = pixels_in({glm::ivec2(0), picture.tile_size_});
  picture.host_memory_ = TRY(task.context.reserve(
      pixels * (sizeof(glm::uvec4) + (see_through ? sizeof(std::uint32_t) : 0)), "a tile of a picture"));
  picture.counts_.resize(pixels);
  if (see_through) {
    picture.places_.resize(pixels);
    GLint64 most = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
    picture.most_fragments_ = std::min(task.list_bytes, static_cast<std::uint64_t>(most)) / kFragmentBytes;
  }
  picture.met_ = gl::GlBuffer::make();
  picture.fragments_ = gl::GlBuffer::make();
  constexpr GLuint kZero = 0;
  glBindBuffer(GL_ATOMIC_COUNTER_BUFFER, picture.met_.name());
  glBufferData(GL_ATOMIC_COUNTER_BUFFER, sizeof(kZero), &kZero, GL_DYNAMIC_READ);
  glBindBufferBase(GL_ATOMIC_COUNTER_BUFFER, 0, picture.met_.name());
  if (task.volume != nullptr) picture.within_ = pixels_of(task.camera, size, *task.scene.volume);
  return picture;
}

Result<void> GpuPicture::draw(Rendered& rendered) {
  const PictureSize& size = task_.options.size;
  task_.context.progress().begin("drawing",
                                 static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height));
  for (int y = 0; y < size.height; y += tile_size_.y) {
    for (int x = 0; x < size.width; x += tile_size_.x) {
      const glm::ivec2 min(x, y);
      if (auto drawn = draw_tile({min, glm::min(min + tile_size_, glm::ivec2(size.width, size.height))}, rendered);
          !drawn) {
        return drawn;
      }
    }
  }
  return {};
}

Result<void> GpuPicture::draw_tile(const PixelBox& tile, Rendered& rendered) {
  if (!task_.surfaces.empty()) {
    TRY(draw_opaque(tile));
  }
  if (task_.surfaces.has_transparent_triangles()) {
    const auto count = TRY(count_fragments(tile));
    if (count > most_fragments_) {
      if (pixels_in(tile) == 1) {
        return fail(ErrorCode::unavailable,
                    fmt::format("{}: expected at most {} surface layers in a pixel, found {}",
                                task_.gl.device().renderer, most_fragments_, count),
                    {Remedy::use, Setting::cpu_backend});
      }
      for (const PixelBox& half : halves(tile)) {
        TRY(draw_tile(half, rendered));
      }
      return {};
    }
    TRY(list_fragments(tile, count));
  }
  if (!task_.surfaces.empty()) {
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    GLuint met = 0;
    glBindBuffer(GL_ATOMIC_COUNTER_BUFFER, met_.name());
    glGetBufferSubData(GL_ATOMIC_COUNTER_BUFFER, 0, sizeof(met), &met);
    rendered.statistics.fragments += met;
  }

  const PixelBox within = common_of(tile, within_);
  targets_->begin_rays(tile);
  TRY(cast_rays(tile, within, true));
  for (const PixelBox& part : around(tile, within)) {
    TRY(cast_rays(tile, part, false));
  }
  const bool whole = targets_->read(tile, rendered.picture, counts_, rendered.statistics);
  TRY(task_.gl.check("reading a picture"));
  if (whole) return {};
  return fail(ErrorCode::unavailable,
              fmt::format("{}: a ray needs more loop iterations (samples and surface layers) than the driver allows",
                          task_.gl.device().renderer),
              {Remedy::use, Setting::cpu_backend});
}

Result<void> GpuPicture::draw_opaque(const PixelBox& tile) {
  const auto program = TRY(task_.programs.get(task_.gl, GpuPrograms::Name::opaque));
  constexpr GLuint kZero = 0;
  glBindBuffer(GL_ATOMIC_COUNTER_BUFFER, met_.name());
  glBufferSubData(GL_ATOMIC_COUNTER_BUFFER, 0, sizeof(kZero), &kZero);
  targets_->begin_opaque(tile);
  if (!task_.surfaces.has_opaque_triangles()) return {};
  set_view(*program, tile);
  set_clip(*program, tile);
  return task_.surfaces.draw(task_.gl, *program, true, task_.context);
}

Result<void> GpuPicture::draw_lists(const PixelBox& tile, bool counting) {
  const auto program = TRY(task_.programs.get(task_.gl, GpuPrograms::Name::see_through));
  targets_->begin_lists(tile, counting, places_);
  set_view(*program, tile);
  set_clip(*program, tile);
  targets_->bind_opaque(*program);
  program->set("list_them", counting ? 0 : 1);
  return task_.surfaces.draw(task_.gl, *program, false, task_.context);
}

Result<std::uint64_t> GpuPicture::count_fragments(const PixelBox& tile) {
  std::ranges::fill(places_, 0U);
  TRY(draw_lists(tile, true));
  targets_->read_counts(tile, places_);
  std::uint64_t count = 0;
  const std::size_t pixels = pixels_in(tile);
  for (std::size_t p = 0; p < pixels; ++p) {
    // Truncation to 32 bits is harmless: with so many fragments the tile is split instead of listed.
    count += std::exchange(places_[p], static_cast<std::uint32_t>(count));
  }
  return count;
}

Result<void> GpuPicture::list_fragments(const PixelBox& tile, std::uint64_t count) {
  // A buffer needs at least one byte.
  if (const std::uint64_t wanted = std::max<std::uint64_t>(count, 1); wanted > fragments_taken_) {
    if (auto taken = memory_.take((wanted - fragments_taken_) * kFragmentBytes, "the surface layers"); !taken) {
      return taken;
    }
    fragments_taken_ = wanted;
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, fragments_.name());
    glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(wanted * kFragmentBytes), nullptr, GL_DYNAMIC_COPY);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, fragments_.name());
    TRY(task_.gl.check("allocating memory for surface layers"));
  }
  return draw_lists(tile, false);
}

Result<void> GpuPicture::cast_rays(const PixelBox& tile, const PixelBox& box, bool volume) {
  if (box.empty()) return {};
  const bool surfaces = !task_.surfaces.empty();
  const auto program = TRY(task_.programs.get(
      task_.gl, GpuPrograms::rays(volume, task_.volume != nullptr && task_.volume->has_emission(), surfaces)));
  const gl::ShaderProgram& rays = *program;
  set_view(rays, tile);
  const RenderOptions& options = task_.options;
  rays.set("unit", task_.camera.unit());
  rays.set("least_light", options.early_termination ? static_cast<float>(options.termination) : 0.0F);
  rays.set("background", glm::vec4(task_.scene.background));
  if (volume) task_.volume->bind(rays, task_.camera);
  if (surfaces) {
    task_.surfaces.bind_shading(rays);
    targets_->bind_opaque(rays);
    targets_->bind_lists(rays);
    rays.set("has_lists", task_.surfaces.has_transparent_triangles() ? 1 : 0);
  }
  rays.use();
  const int width = box.max.x - box.min.x;
  const int rows = std::max(1, kStripPixels / width);
  for (int y = box.min.y; y < box.max.y; y += rows) {
    const int height = std::min(rows, box.max.y - y);
    glScissor(box.min.x - tile.min.x, y - tile.min.y, width, height);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glFinish();
    TRY(task_.gl.check("casting rays"));
    TRY(task_.context.check());
    task_.context.progress().advance(static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height));
  }
  return {};
}

void GpuPicture::set_view(const gl::ShaderProgram& program, const PixelBox& tile) const {
  program.set("to_corner", task_.view.to_corner());
  program.set("per_pixel", task_.view.per_pixel());
  program.set("tile_first", tile.min);
  program.set("near_depth", task_.camera.near_depth / task_.camera.unit());
  program.set("far_depth", task_.camera.far_depth / task_.camera.unit());
  if (!task_.surfaces.empty()) task_.surfaces.bind_triangles(program);
}

void GpuPicture::set_clip(const gl::ShaderProgram& program, const PixelBox& tile) const {
  const glm::dvec2 size(tile.max - tile.min);
  const glm::dvec2 first(tile.min);
  // The pixel of a point in view space is (x / depth - corner.x) / per_pixel.x, (corner.y - y / depth) / per_pixel.y.
  const glm::dvec2 per_pixel = task_.view.per_pixel() * glm::dvec2(1, -1);
  program.set("clip_scale", 2.0 / (per_pixel * size));
  program.set("clip_shift", 2.0 * (-task_.view.to_corner() / per_pixel - first) / size - 1.0);
}

}  // namespace isoextract::render::detail
