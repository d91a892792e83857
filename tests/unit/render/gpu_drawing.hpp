// A GPU renderer for tests; every message of the driver is an error.
#pragma once

#include <memory>

#include "render/gpu_renderer.hpp"
#include "unit/render/drawing.hpp"

namespace isoextract::test {

// Opens the renderer on first use and destroys it before the program ends.
class GpuRenderers final : public testing::Environment {
 public:
  render::Renderer* find() {
    if (renderer_ == nullptr) {
      render::GpuRenderOptions options;
      options.debug = true;
      auto made = render::make_gpu_renderer(options);
      if (!made) {
        ADD_FAILURE() << made.error().message;
        return nullptr;
      }
      renderer_ = std::move(made->renderer);
    }
    return renderer_.get();
  }
  void TearDown() override { renderer_.reset(); }

 private:
  std::unique_ptr<render::Renderer> renderer_;
};

inline auto* const kGpuRenderers =
    static_cast<GpuRenderers*>(testing::AddGlobalTestEnvironment(new GpuRenderers));  // owned by gtest

inline render::Rendered draw_on_gpu(const render::Scene& scene, const render::Camera& camera,
                                    const render::RenderOptions& options, const Context& context = Context()) {
  render::Renderer* renderer = kGpuRenderers->find();
  if (renderer == nullptr) return {};
  auto rendered = renderer->draw(scene, camera, options, context);
  EXPECT_TRUE(rendered) << (rendered ? "" : rendered.error().message);
  return rendered ? std::move(*rendered) : render::Rendered();
}

// Counts the pixels in which two pictures differ by more than the model allows.
inline std::size_t pixels_off(const render::Picture& a, const render::Picture& b, float bound = 2.0F / 255) {
  EXPECT_EQ(a.pixels(), b.pixels());
  std::size_t off = 0;
  for (std::size_t i = 0; i < a.pixels() && i < b.pixels(); ++i) {
    bool same = true;
    for (int c = 0; c < 4; ++c) same = same && std::abs(a.color[i][c] - b.color[i][c]) <= bound;
    off += same ? 0 : 1;
  }
  return off;
}

}  // namespace isoextract::test
