// Tests that keeping a volume between pictures changes no bit, repeats no work, and releases data in time.
#include "unit/render/gpu_drawing.hpp"

namespace isoextract::render {
namespace {

constexpr PictureSize kPictureSize{48, 40};

class KeptVolume : public testing::TestWithParam<bool> {
 protected:
  KeptVolume()
      : dense_(test::ball(40)),
        sparse_(test::sparse_copy<float>(dense_, 0)),
        rectangle_(test::rectangle(20, 5, 35, -3, 30)) {
    for (Volume* volume : {&volume_, &other_}) {
      *volume = {&dense_, {}, test::rising_transfer(0.1, 0.3), 1};
    }
    scene_.surfaces.push_back({&rectangle_, {0.9, 0.8, 0.1}, 0.6});
    scene_.volume = &volume_;
    if (GetParam()) {
      renderer_ = test::kGpuRenderers->find();
    } else {
      on_cpu_ = make_cpu_renderer();
      renderer_ = on_cpu_.get();
    }
  }
  ~KeptVolume() override {
    if (renderer_ != nullptr) renderer_->keep(nullptr);
  }
  Rendered draw(double azimuth, const RenderOptions& options = {kPictureSize}) {
    const Camera camera = frame_box({glm::dvec3(0), glm::dvec3(39)}, {azimuth, 15}, UpAxis::z, kPictureSize);
    auto drawn = renderer_->draw(scene_, camera, options, context_);
    EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
    return drawn ? std::move(*drawn) : Rendered();
  }

  field::ScalarField dense_;
  field::ScalarField sparse_;
  mesh::Mesh rectangle_;
  Volume volume_;
  Volume other_;
  Scene scene_;
  const Context context_;
  std::unique_ptr<Renderer> on_cpu_;
  Renderer* renderer_ = nullptr;
};

TEST_P(KeptVolume, ReadsVolumeOnceForSeveralViews) {
  ASSERT_NE(renderer_, nullptr);
  for (const field::ScalarField* field : {&dense_, &sparse_}) {
    volume_.field = field;
    std::vector<Rendered> anew;
    for (const double azimuth : {0.0, 70.0, 200.0}) anew.push_back(draw(azimuth));
    renderer_->keep(&volume_);
    int number = 0;
    for (const double azimuth : {0.0, 70.0, 200.0}) {
      const Rendered drawn = draw(azimuth);
      const Rendered& expected = anew[static_cast<std::size_t>(number)];
      EXPECT_TRUE(test::same_picture(expected.picture, drawn.picture)) << azimuth;
      EXPECT_EQ(expected.statistics, drawn.statistics) << azimuth;
      EXPECT_FALSE(expected.reused_volume);
      EXPECT_EQ(drawn.reused_volume, number > 0);
      ++number;
    }
    renderer_->keep(nullptr);
  }
}

TEST_P(KeptVolume, DoesNotReadSamplesAgain) {
  // Violates the contract on purpose to see whether samples are read: brick ranges from before the ball was added hide
  // it.
  ASSERT_NE(renderer_, nullptr);
  auto* samples = std::get<field::DenseSamples>(dense_.samples).data;
  auto* values = static_cast<float*>(const_cast<void*>(static_cast<const void*>(samples)));
  const std::vector<float> ball(values, values + 40 * 40 * 40);
  scene_.surfaces.clear();
  const auto most = [](const Rendered& drawn) {
    float largest = 0;
    for (const glm::vec4& pixel : drawn.picture.color) largest = std::max(largest, pixel.a);
    return largest;
  };
  std::fill(values, values + ball.size(), 0.0F);
  renderer_->keep(&volume_);
  EXPECT_EQ(most(draw(0)), 0);
  std::ranges::copy(ball, values);
  EXPECT_EQ(most(draw(0)), 0);
  renderer_->keep(nullptr);
  EXPECT_GT(most(draw(0)), 0.5F);
}

TEST_P(KeptVolume, ServesOnlySameVolumeAndOptions) {
  ASSERT_NE(renderer_, nullptr);
  renderer_->keep(&volume_);
  EXPECT_FALSE(draw(0).reused_volume);
  EXPECT_TRUE(draw(0).reused_volume);
  RenderOptions options{kPictureSize};
  options.empty_space_skipping = false;
  const Rendered all = draw(0, options);
  EXPECT_FALSE(all.reused_volume);
  EXPECT_EQ(all.statistics.samples_skipped, 0U);
  EXPECT_EQ(all.statistics.bricks, 0U);
  EXPECT_TRUE(draw(0, options).reused_volume);
  options.empty_space_skipping = true;
  EXPECT_GT(draw(0, options).statistics.samples_skipped, 0U);

  other_.transfer = test::rising_transfer(0.5, 0.9);
  scene_.volume = &other_;
  EXPECT_FALSE(draw(0).reused_volume);
  EXPECT_FALSE(draw(0).reused_volume);
  scene_.volume = nullptr;
  EXPECT_FALSE(draw(0).reused_volume);
  scene_.volume = &volume_;
  EXPECT_TRUE(draw(0).reused_volume);
}

TEST_P(KeptVolume, HoldsItsMemoryReservation) {
  ASSERT_NE(renderer_, nullptr);
  draw(0);
  EXPECT_EQ(context_.memory().reserved(), 0U);
  renderer_->keep(&volume_);
  draw(0);
  const std::uint64_t kept = context_.memory().reserved();
  EXPECT_GE(kept, 125U) << "bytes for 125 bricks";
  draw(90);
  EXPECT_EQ(context_.memory().reserved(), kept);
  renderer_->keep(nullptr);
  EXPECT_EQ(context_.memory().reserved(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Renderers, KeptVolume, testing::Bool(),
                         [](const auto& test) { return test.param ? "Gpu" : "Cpu"; });

}  // namespace
}  // namespace isoextract::render
