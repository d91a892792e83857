// Tests that shortcuts do not change pictures: empty bricks, early termination, threads, scenes of any size.
#include <cmath>
#include <limits>

#include <tbb/global_control.h>

#include "unit/render/drawing.hpp"

namespace isoextract::render {
namespace {

constexpr PictureSize kFrame{70, 50};

// A ball with a plane through it, from the side.
class BallScene {
 public:
  explicit BallScene(field::ScalarField field, double scale = 1, double opacity = 0.2)
      : field_(std::move(field)),
        rectangle_(test::rectangle(20 * scale, 5 * scale, 35 * scale, -3 * scale, 30 * scale)) {
    volume_ = {&field_, field::scaling(glm::dvec3(scale)), test::rising_transfer(0.1, opacity), scale};
    scene_.volume = &volume_;
    scene_.surfaces.push_back({&rectangle_, {0.9, 0.8, 0.1}, 0.6});
    camera_ = frame_box({glm::dvec3(0), glm::dvec3(39 * scale)}, {25, 15}, UpAxis::z, kFrame);
  }
  [[nodiscard]] Rendered draw(const RenderOptions& options) const { return test::draw(scene_, camera_, options); }
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const Camera& camera() const { return camera_; }

 private:
  field::ScalarField field_;
  mesh::Mesh rectangle_;
  Volume volume_;
  Scene scene_;
  Camera camera_;
};

RenderOptions without_shortcuts() {
  RenderOptions options{kFrame};
  options.early_termination = false;
  options.empty_space_skipping = false;
  return options;
}

std::uint64_t all_samples(const RenderStatistics& statistics) {
  return statistics.samples + statistics.samples_skipped + statistics.samples_terminated;
}

TEST(Skipping, SkipsEmptyBricksWithoutChange) {
  const field::ScalarField dense = test::ball(40);
  for (const bool sparse : {false, true}) {
    const BallScene ball(sparse ? test::sparse_copy<float>(dense, 0) : test::ball(40));
    RenderOptions options = without_shortcuts();
    const Rendered all = ball.draw(options);
    EXPECT_EQ(all.statistics.samples_skipped, 0U);
    options.empty_space_skipping = true;
    const Rendered skipped = ball.draw(options);
    EXPECT_TRUE(test::same_picture(all.picture, skipped.picture)) << sparse;
    EXPECT_GT(skipped.statistics.samples_skipped, all.statistics.samples / 4);
    EXPECT_GT(skipped.statistics.bricks_skipped, 0U);
    EXPECT_LT(skipped.statistics.bricks_skipped, skipped.statistics.bricks);
    EXPECT_EQ(all_samples(skipped.statistics), all.statistics.samples);
  }
}

TEST(Skipping, SeesBrickWithOneVisibleSample) {
  // One visible sample at the corner of eight bricks.
  const auto field = test::dense_field<float>(
      glm::ivec3(33), [](int i, int j, int k) { return i == 16 && j == 16 && k == 16 ? 1 : 0; });
  Volume volume{&field, {}, test::rising_transfer(0.01, 0.5), 1};
  Scene scene;
  scene.volume = &volume;
  const Camera camera = frame_box({glm::dvec3(15), glm::dvec3(17)}, {30, 40}, UpAxis::z, kFrame);
  RenderOptions options = without_shortcuts();
  options.samples_per_voxel = 4;
  const Rendered all = test::draw(scene, camera, options);
  options.empty_space_skipping = true;
  const Rendered skipped = test::draw(scene, camera, options);
  EXPECT_TRUE(test::same_picture(all.picture, skipped.picture));
  EXPECT_EQ(skipped.statistics.bricks, 64U);
  EXPECT_EQ(skipped.statistics.bricks_skipped, 56U);
  float most = 0;
  for (const glm::vec4& pixel : all.picture.color) most = std::max(most, pixel.a);
  EXPECT_GT(most, 0.1F);
}

TEST(Skipping, DrawsSparseLikeDense) {
  const BallScene dense(test::ball(40));
  const BallScene sparse(test::sparse_copy<float>(test::ball(40), 0));
  RenderOptions options{kFrame};
  options.samples_per_voxel = 4;
  // The sparse volume's box is a voxel larger, so samples are at other positions along the ray.
  EXPECT_LT(test::largest_difference(dense.draw(options).picture, sparse.draw(options).picture), 0.02F);
}

TEST(Skipping, TerminatesRaysWithinBound) {
  const BallScene ball(test::ball(40), 1, 0.7);
  RenderOptions options = without_shortcuts();
  const Rendered all = ball.draw(options);
  options.early_termination = true;
  for (const double termination : {1.0 / 512, 0.1}) {
    options.termination = termination;
    const Rendered ended = ball.draw(options);
    EXPECT_GT(ended.statistics.samples_terminated, all.statistics.samples / 20);
    EXPECT_EQ(all_samples(ended.statistics), all.statistics.samples);
    const float difference = test::largest_difference(all.picture, ended.picture);
    EXPECT_GT(difference, 0);
    EXPECT_LE(difference, termination * 1.01);
  }
}

TEST(Skipping, DrawsSamePictureForAnyThreadCount) {
  const BallScene ball(test::ball(40));
  const Rendered all = ball.draw({kFrame});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Rendered alone = ball.draw({kFrame});
  EXPECT_TRUE(test::same_picture(all.picture, alone.picture));
  EXPECT_EQ(all.statistics, alone.statistics);
}

TEST(Skipping, DrawsHugeAndTinyScenesAlike) {
  const Picture usual = BallScene(test::ball(40)).draw({kFrame}).picture;
  for (const double scale : {1e-30, 1e-6, 1e9, 1e30}) {
    const Picture picture = BallScene(test::ball(40), scale).draw({kFrame}).picture;
    EXPECT_LT(test::largest_difference(usual, picture), 1e-4F) << scale;
  }
}

TEST(Skipping, HidesNan) {
  const double kHuge = std::numeric_limits<double>::infinity();
  for (const double strange : {test::kNaN, kHuge, -kHuge, 3e38}) {
    auto field = test::dense_field<float>(
        glm::ivec3(20), [&](int i, int j, int k) { return i == 10 && j == 10 && k == 10 ? strange : 0; });
    Volume volume{&field, {}, test::rising_transfer(0.5, 0.5), 1};
    Scene scene;
    scene.volume = &volume;
    const Camera camera = frame_box({glm::dvec3(8), glm::dvec3(12)}, {30, 40}, UpAxis::z, kFrame);
    const Rendered rendered = test::draw(scene, camera, {kFrame});
    float most = 0;
    for (const glm::vec4& pixel : rendered.picture.color) {
      for (int c = 0; c < 4; ++c) ASSERT_TRUE(std::isfinite(pixel[c])) << strange;
      most = std::max(most, pixel.a);
    }
    if (strange > 1) {
      EXPECT_GT(most, 0.1F) << strange;
    } else {
      EXPECT_EQ(most, 0) << strange;
    }
  }
}

TEST(Skipping, ReadsEverySampleTypeByItsScale) {
  const auto picture_of = [](field::ScalarField field) {
    field.scale = {0.01, 0};
    return BallScene(std::move(field)).draw({kFrame}).picture;
  };
  const auto hundred = [](int i, int j, int k) {
    return std::round(100 * std::clamp((0.7 - glm::length(glm::dvec3(i, j, k) - 19.5) / 19.5) * 5, 0.0, 1.0));
  };
  const Picture expected = picture_of(test::dense_field<double>(glm::ivec3(40), hundred));
  const auto same = [&]<class T>(T) {
    return test::same_picture(expected, picture_of(test::dense_field<T>(glm::ivec3(40), hundred)));
  };
  EXPECT_TRUE(same(std::uint8_t{}));
  EXPECT_TRUE(same(std::int8_t{}));
  EXPECT_TRUE(same(std::uint16_t{}));
  EXPECT_TRUE(same(std::int16_t{}));
  EXPECT_TRUE(same(std::uint32_t{}));
  EXPECT_TRUE(same(std::int32_t{}));
  EXPECT_TRUE(same(field::Half{}));
  EXPECT_TRUE(same(float{}));
}

TEST(Skipping, StopsWhenCancelledOrOutOfMemory) {
  const BallScene ball(test::ball(40));
  const auto renderer = make_cpu_renderer();
  const Context cancelled;
  cancelled.cancel();
  const auto ended = renderer->draw(ball.scene(), ball.camera(), {kFrame}, cancelled);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::cancelled);
  const Context small{MemoryBudget(70 * 50 * Picture::kBytesPerPixel - 1)};
  const auto refused = renderer->draw(ball.scene(), ball.camera(), {kFrame}, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_EQ(small.memory().reserved(), 0U);
}

TEST(Skipping, ReservesFragmentLists) {
  // 300 layers of transparent rectangles in every pixel.
  std::vector<mesh::Mesh> layers;
  for (int i = 0; i < 300; ++i) layers.push_back(test::rectangle(i * 0.01, -9, 9, -9, 9));
  Scene scene;
  for (const mesh::Mesh& layer : layers) scene.surfaces.push_back({&layer, {1, 1, 1}, 0.01});
  Camera camera;
  camera.eye = {0, -4, 0};
  const auto renderer = make_cpu_renderer();
  const Context roomy{MemoryBudget(64U << 20U)};
  const auto drawn = renderer->draw(scene, camera, {{32, 32}}, roomy);
  ASSERT_TRUE(drawn);
  EXPECT_NEAR(drawn->picture.color[77].a, 1 - std::pow(0.99, 300), 1e-5);
  EXPECT_GE(roomy.memory().peak(), 300U * 32 * 32 * 16);
  const Context small{MemoryBudget(300U * 32 * 32 * 16)};
  const auto refused = renderer->draw(scene, camera, {{32, 32}}, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
}

}  // namespace
}  // namespace isoextract::render
