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
  ~GpuRenderer() override { gl_->make_current(); }  // so that the programs are deleted in their context

  Result<Rendered> draw(const Scene& scene, const Camera& camera, const RenderOptions& options,
                        const Context& context) override {
    TRY(check(scene, camera, options));
    // Another context may have become current.
    TRY(gl_->make_current());
    const std::size_t known_messages = gl_->debug_messages().size();
    auto rendered = draw_current(scene, camera, options, context);
    if (rendered && options_.debug && gl_->debug_messages().size() > known_messages) {
      return fail(ErrorCode::unavailable,
                  fmt::format("{}: {}", gl_->device().renderer, gl_->debug_messages()[known_messages]),
                  {{Remedy::report, Setting::devices}, {Remedy::use, Setting::cpu_backend}});
    }
    return rendered;
  }

  void keep(const Volume* volume) override {
    gl_->make_current();  // so that the kept volume is deleted in its context
    kept_.reset();
    to_keep_ = volume;
  }

  [[nodiscard]] std::string device() const override { return gl::describe(gl_->device()); }

 private:
  struct PreparedVolume {
    RenderOptions options;  // the options it was prepared for
    RenderStatistics statistics;
    detail::GpuMemory memory;
    std::optional<detail::GpuVolume> volume;

    [[nodiscard]] bool serves(const RenderOptions& asked) const {
      return asked.empty_space_skipping == options.empty_space_skipping &&
             asked.samples_per_voxel == options.samples_per_voxel;
    }
  };

  [[nodiscard]] Result<std::unique_ptr<PreparedVolume>> prepare(const Volume& volume, const RenderOptions& options,
                                                                const Context& context) const {
    auto made = std::make_unique<PreparedVolume>(PreparedVolume{
        options, {}, detail::GpuMemory(gl_->device(), options_.memory_bytes, kept_bytes(), context), {}});
    auto uploaded = TRY(detail::GpuVolume::upload(*gl_, volume, options, made->statistics, made->memory, context));
    made->volume.emplace(std::move(uploaded));
    return made;
  }

  [[nodiscard]] std::uint64_t kept_bytes() const { return kept_ ? kept_->memory.taken() : 0; }

  Result<Rendered> draw_current(const Scene& scene, const Camera& camera, const RenderOptions& options,
                                const Context& context) {
    glDisable(GL_RASTERIZER_DISCARD);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    Rendered rendered;
    rendered.picture = TRY(make_picture(options.size.width, options.size.height, context));

    std::unique_ptr<PreparedVolume> own;  // used for this picture only
    const detail::GpuVolume* volume = nullptr;
    if (scene.volume != nullptr) {
      std::unique_ptr<PreparedVolume>& prepared = scene.volume == to_keep_ ? kept_ : own;
      rendered.reused_volume = prepared != nullptr && prepared->serves(options);
      if (!rendered.reused_volume) {
        prepared.reset();
        prepared = TRY(prepare(*scene.volume, options, context));
      }
      rendered.statistics = prepared->statistics;
      volume = &*prepared->volume;
    }
    detail::GpuMemory memory(gl_->device(), options_.memory_bytes, own ? own->memory.taken() : kept_bytes(), context);
    const detail::SurfaceView view(scene, camera, options.size);
    const auto surfaces = TRY(detail::GpuSurfaces::upload(*gl_, scene, view, memory, context));
    auto drawing = TRY(detail::GpuPicture::make(
        {*gl_, programs_, scene, camera, options, view, surfaces, volume, options_.list_bytes, context}, memory));
    TRY(drawing.draw(rendered));
    return rendered;
  }

  std::unique_ptr<gl::GlContext> gl_;  // first member, so that it is destroyed last
  GpuRenderOptions options_;
  detail::GpuPrograms programs_;
  const Volume* to_keep_ = nullptr;
  std::unique_ptr<PreparedVolume> kept_;  // prepared from that volume
};

}  // namespace

Result<GpuRendererAndDevice> make_gpu_renderer(const GpuRenderOptions& options) {
  auto context = TRY(gl::GlContext::open({options.device, options.debug}));
  gl::GpuDevice device = context->device();
  return GpuRendererAndDevice{std::make_unique<GpuRenderer>(std::move(context), options), std::move(device)};
}

}  // namespace isoextract::render
