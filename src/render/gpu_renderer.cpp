#include "render/gpu_renderer.hpp"

#include <optional>
#include <utility>

#include <fmt/format.h>

#include "gl/gl_context.hpp"
#include "render/detail/gpu_picture.hpp"

namespace isoextract::render {
namespace {

class GpuRenderer final : public Renderer {
 public:
  GpuRenderer(std::unique_ptr<gl::GlContext> gl, const GpuRenderOptions& options)
      : gl_(std::move(gl)), options_(options) {}

  GpuRenderer(const GpuRenderer&) = delete;
  GpuRenderer& operator=(const GpuRenderer&) = delete;
  ~GpuRenderer() override { gl_->make_current(); }  // for the programs

  Result<Rendered> draw(const Scene& scene, const Camera& camera, const RenderOptions& options,
                        const Context& context) override {
    if (auto sound = check(scene, camera, options); !sound) return tl::unexpected(std::move(sound.error()));
    // Another context may have come since.
    if (auto current = gl_->make_current(); !current) return tl::unexpected(std::move(current.error()));
    const std::size_t known_messages = gl_->debug_messages().size();
    auto rendered = draw_current(scene, camera, options, context);
    if (rendered && options_.debug && gl_->debug_messages().size() > known_messages) {
      return fail(ErrorKind::unavailable,
                  fmt::format("{}: {}", gl_->device().renderer, gl_->debug_messages()[known_messages]),
                  Remedy::report_gpu);
    }
    return rendered;
  }

  [[nodiscard]] std::string device() const override { return gl::describe(gl_->device()); }

 private:
  Result<Rendered> draw_current(const Scene& scene, const Camera& camera, const RenderOptions& options,
                                const Context& context) {
    glDisable(GL_RASTERIZER_DISCARD);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    Rendered rendered;
    auto picture = make_picture(options.size.width, options.size.height, context);
    if (!picture) return tl::unexpected(std::move(picture.error()));
    rendered.picture = std::move(*picture);

    detail::GpuMemory memory(gl_->device(), options_.memory_bytes, context);
    const detail::SurfaceView view(scene, camera, options.size);
    const auto surfaces = detail::GpuSurfaces::upload(*gl_, scene, view, memory, context);
    if (!surfaces) return tl::unexpected(surfaces.error());
    std::optional<detail::GpuVolume> volume;
    if (scene.volume != nullptr) {
      auto uploaded = detail::GpuVolume::upload(*gl_, *scene.volume, options, rendered.statistics, memory, context);
      if (!uploaded) return tl::unexpected(std::move(uploaded.error()));
      volume.emplace(std::move(*uploaded));
    }
    auto drawing = detail::GpuPicture::make({*gl_, programs_, scene, camera, options, view, *surfaces,
                                             volume ? &*volume : nullptr, options_.list_bytes, context},
                                            memory);
    if (!drawing) return tl::unexpected(std::move(drawing.error()));
    if (auto drawn = drawing->draw(rendered); !drawn) return tl::unexpected(std::move(drawn.error()));
    return rendered;
  }

  std::unique_ptr<gl::GlContext> gl_;  // first, so that it goes last
  GpuRenderOptions options_;
  detail::GpuPrograms programs_;
};

}  // namespace

Result<GpuRendererAndDevice> make_gpu_renderer(const GpuRenderOptions& options) {
  auto context = gl::GlContext::open({options.device, options.debug});
  if (!context) return tl::unexpected(std::move(context.error()));
  gl::GpuDevice device = (*context)->device();
  return GpuRendererAndDevice{std::make_unique<GpuRenderer>(std::move(*context), options), std::move(device)};
}

}  // namespace isoextract::render
