// Tests a GPU renderer's picture sizes, limits, refusals and cleanup.
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "gl/gl_object.hpp"
#include "support/hints.hpp"
#include "unit/render/gpu_drawing.hpp"

namespace isoextract::render {
namespace {

// A ball inside layers, two of which are transparent.
class BallInLayers {
 public:
  BallInLayers() {
    scene_.volume = &volume_;
    for (const auto& [mesh, opacity] : {std::pair(&layers_[0], 0.5), std::pair(&layers_[1], 0.5)}) {
      scene_.surfaces.push_back({mesh, {0.5, 0.6, 0.1}, opacity});
    }
    scene_.surfaces.push_back({&layers_[2]});
  }
  BallInLayers(const BallInLayers&) = delete;
  BallInLayers& operator=(const BallInLayers&) = delete;
  const Scene& scene() const { return scene_; }
  Camera camera(const PictureSize& size) const { return frame_box(*box_of(scene_), {30, 10}, UpAxis::z, size); }

 private:
  field::ScalarField field_ = test::ball(24);
  std::array<mesh::Mesh, 3> layers_{test::rectangle(-2, -2, 26, -2, 26), test::rectangle(9.3, -2, 26, -2, 26),
                                    test::rectangle(25, -2, 26, -2, 26)};
  Volume volume_{&field_, field_.index_to_world, test::rising_transfer(0.2, 0.3), 1};
  Scene scene_;
};

Result<Rendered> draw_with(const GpuRenderOptions& how, const PictureSize& size, const Context& context = Context()) {
  const BallInLayers setup;
  auto made = TRY(make_gpu_renderer(how));
  return made.renderer->draw(setup.scene(), setup.camera(size), {size}, context);
}

TEST(GpuRenderer, DrawsPicturesOfDifferentSizes) {
  const BallInLayers setup;
  // The third picture is drawn in two tiles.
  for (const PictureSize& size : {PictureSize{64, 48}, {1, 1}, {1200, 900}, {7, 300}, {64, 48}}) {
    const RenderOptions options{size};
    const Camera camera = setup.camera(size);
    const Rendered cpu = test::draw(setup.scene(), camera, options);
    const Rendered gpu = test::draw_on_gpu(setup.scene(), camera, options);
    ASSERT_EQ(gpu.picture.width, size.width);
    ASSERT_EQ(gpu.picture.height, size.height);
    EXPECT_LE(test::pixels_off(cpu.picture, gpu.picture), gpu.picture.pixels() / 300) << size.width;
  }
}

TEST(GpuRenderer, SplitsTilesWithLongLists) {
  const PictureSize size{61, 47};
  const auto whole = draw_with({}, size);
  ASSERT_TRUE(whole) << whole.error().message;
  GpuRenderOptions how;
  how.list_bytes = 8 * 100;
  const auto parts = draw_with(how, size);
  ASSERT_TRUE(parts) << parts.error().message;
  // Tiles round corners to different rasters, so pixels on an edge may differ.
  EXPECT_LE(test::pixels_off(whole->picture, parts->picture, 1e-4F), parts->picture.pixels() / 200);

  how.list_bytes = 8;
  const auto refused = draw_with(how, size);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unavailable);
  EXPECT_NE(refused.error().message.find("expected at most 1 surface layers in a pixel, found 2"), std::string::npos)
      << refused.error().message;
}

TEST(GpuRenderer, KeepsMemoryLimit) {
  GpuRenderOptions how;
  how.memory_bytes = 1 << 16;
  const auto refused = draw_with(how, {64, 48});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unavailable);
  EXPECT_TRUE(test::has_step(refused.error().hint, Remedy::raise, Setting::gpu_memory));
  EXPECT_NE(refused.error().message.find("the GPU memory limit is 64 KiB"), std::string::npos)
      << refused.error().message;
}

TEST(GpuRenderer, ReservesHostMemoryOnSoftwareDevice) {
  const auto refused = draw_with({}, {64, 48}, Context(MemoryBudget(1 << 18)));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
}

TEST(GpuRenderer, StopsWhenCancelled) {
  const Context context;
  context.cancel();
  const auto ended = draw_with({}, {64, 48}, context);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::cancelled);
}

// llvmpipe stops loops after 65,535 iterations; other devices draw the picture.
TEST(GpuRenderer, FailsIfDriverCutsRaysOff) {
  const auto field = test::dense_field<std::uint8_t>({1100, 2, 2}, [](int, int, int) { return 1; });
  const Volume volume{&field, field::scaling({1e-3, 1, 1}), test::constant_transfer({1, 1, 1}, 0.5), 1};
  Scene scene;
  scene.volume = &volume;
  Camera camera;
  camera.eye = {-10, 0.5, 0.5};
  camera.target = {0, 0.5, 0.5};
  RenderOptions options{{1, 1}};
  options.samples_per_voxel = 64;
  ASSERT_NE(test::kGpuRenderers->find(), nullptr);
  const auto drawn = test::kGpuRenderers->find()->draw(scene, camera, options, Context());
  if (drawn) {
    EXPECT_LE(test::pixels_off(test::draw(scene, camera, options).picture, drawn->picture), 0U);
  } else {
    EXPECT_EQ(drawn.error().code, ErrorCode::unavailable);
    EXPECT_EQ(drawn.error().hint, Hint(Remedy::use, Setting::cpu_backend));
  }
}

TEST(GpuRenderer, RefusesMissingDevice) {
  GpuRenderOptions how;
  how.device = 99;
  const auto made = make_gpu_renderer(how);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::unavailable);
}

TEST(GpuRenderer, DeletesAllDeviceObjects) {
  const BallInLayers setup;
  const PictureSize size{40, 30};
  // Counts the names that refer to objects, since drivers need not reuse names.
  const auto objects = [&] {
    test::draw_on_gpu(setup.scene(), setup.camera(size), {size});
    const GLuint names =
        std::max({gl::GlTexture::make().name(), gl::GlBuffer::make().name(), gl::GlFramebuffer::make().name()});
    int count = 0;
    for (GLuint name = 1; name <= names; ++name) {
      count +=
          (glIsTexture(name) != 0 ? 1 : 0) + (glIsBuffer(name) != 0 ? 1 : 0) + (glIsFramebuffer(name) != 0 ? 1 : 0);
    }
    return count;
  };
  const int first = objects();
  objects();
  EXPECT_EQ(objects(), first);
}

TEST(GpuRenderer, WorksWithAnotherContext) {
  const BallInLayers setup;
  const PictureSize size{40, 30};
  const Rendered alone = test::draw_on_gpu(setup.scene(), setup.camera(size), {size});
  const auto other = draw_with({}, size);
  ASSERT_TRUE(other);
  const Rendered again = test::draw_on_gpu(setup.scene(), setup.camera(size), {size});
  EXPECT_TRUE(test::same_picture(alone.picture, again.picture));
  EXPECT_TRUE(test::same_picture(alone.picture, other->picture));
}

}  // namespace
}  // namespace isoextract::render
