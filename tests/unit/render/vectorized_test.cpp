// Compares vectorized rays with plain ones, for every instruction set of the machine.
#include <cmath>
#include <string>

#include <hwy/targets.h>

#include "unit/render/plain_rays.hpp"

namespace isoextract::render {
namespace {

// Tolerance in float: exponentials may differ in the last bits of a double, which changes few floats by one unit.
constexpr float kTolerance = 0x1p-22F;

// A soft ball with ripples, a transparent plane and an opaque one.
class RippledBall {
 public:
  explicit RippledBall(field::ScalarField field, double scale = 1)
      : field_(std::move(field)),
        front_(test::rectangle(12, 2, 20, -3, 30)),
        middle_(test::rectangle(19.3, 5, 35, 0, 39)),
        back_(test::rectangle(29, 15, 33, 10, 60)) {
    field_.scale = {scale, 0};
    volume_ = {&field_, {}, test::rising_transfer(0.3, 0.3), 1};
    scene_.volume = &volume_;
    scene_.surfaces = {{&front_, {0.9, 0.1, 0.1}, 0.3}, {&middle_, {0.9, 0.8, 0.1}, 0.5}, {&back_, {0.2, 0.9, 0.4}, 1}};
    camera_ = frame_box({glm::dvec3(0), glm::dvec3(39)}, {25, 15}, UpAxis::z, size());
  }
  static PictureSize size() { return {67, 45}; }
  static double value(int i, int j, int k) {
    const double r = glm::length(glm::dvec3(i, j, k) - 19.5) / 19.5;
    return std::clamp((0.8 - r) * 3 + 0.3 * std::sin(i * 1.7) * std::sin(j * 0.9 + k), 0.0, 1.2);
  }
  Volume& volume() { return volume_; }
  const Scene& scene() const { return scene_; }
  const Camera& camera() const { return camera_; }

 private:
  field::ScalarField field_;
  mesh::Mesh front_;
  mesh::Mesh middle_;
  mesh::Mesh back_;
  Volume volume_;
  Scene scene_;
  Camera camera_;
};

void expect_same(const Rendered& plain, const Rendered& vectorized, const std::string& what) {
  EXPECT_EQ(plain.statistics, vectorized.statistics) << what;
  EXPECT_LE(test::largest_difference(plain.picture, vectorized.picture), kTolerance) << what;
  for (std::size_t i = 0; i < plain.picture.pixels(); ++i) {
    ASSERT_EQ(plain.picture.depth[i], vectorized.picture.depth[i]) << what << ": pixel " << i;
    ASSERT_EQ(plain.picture.normals[i], vectorized.picture.normals[i]) << what << ": pixel " << i;
  }
}

std::string target_name(std::int64_t target) { return hwy::TargetName(target); }

// Calls f(name) for each instruction set of the machine.
template <class F>
void with_every_target(const F& f) {
  for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
    const std::int64_t target = targets & -targets;
    hwy::SetSupportedTargetsForTest(target | HWY_SCALAR);
    f(target_name(target));
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(Vectorized, MatchesPlainRaysForEveryInstructionSet) {
  for (const bool sparse : {false, true}) {
    const auto dense = test::dense_field<float>(glm::ivec3(40), &RippledBall::value);
    const RippledBall ball(sparse ? test::sparse_copy<float>(dense, 0)
                                  : test::dense_field<float>(glm::ivec3(40), &RippledBall::value));
    for (const int shortcuts : {0, 1, 2, 3}) {
      for (const double samples : {0.4, 1.0, 3.7}) {
        RenderOptions options{RippledBall::size()};
        options.early_termination = (shortcuts & 1) != 0;
        options.empty_space_skipping = (shortcuts & 2) != 0;
        options.samples_per_voxel = samples;
        const Rendered plain = test::draw_plainly<float>(ball.scene(), ball.camera(), options);
        EXPECT_GT(plain.statistics.samples, 1000U);
        std::optional<Rendered> first;
        with_every_target([&](const std::string& target) {
          Rendered drawn = test::draw(ball.scene(), ball.camera(), options);
          expect_same(plain, drawn, target);
          if (first) {
            EXPECT_TRUE(test::same_picture(first->picture, drawn.picture)) << target;
          } else {
            first = std::move(drawn);
          }
        });
      }
    }
  }
}

template <class T>
class VectorizedSamples : public testing::Test {};
using Types = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                             field::Half, float, double>;
TYPED_TEST_SUITE(VectorizedSamples, Types);

TYPED_TEST(VectorizedSamples, MatchPlainSamplesOfEveryType) {
  constexpr bool kWhole = !field::is_floating_sample<TypeParam>;
  const auto stored = [](int i, int j, int k) {
    const double value = RippledBall::value(i, j, k);
    return kWhole ? std::round(100 * value) : value;
  };
  const RippledBall ball(test::dense_field<TypeParam>(glm::ivec3(40), stored), kWhole ? 0.01 : 1);
  const RenderOptions options{RippledBall::size()};
  const Rendered plain = test::draw_plainly<TypeParam>(ball.scene(), ball.camera(), options);
  with_every_target(
      [&](const std::string& target) { expect_same(plain, test::draw(ball.scene(), ball.camera(), options), target); });
}

TEST(Vectorized, MatchesPlainRaysForExtremeValues) {
  // Values beyond the table, infinite ones and NaN; integers whose signs or lowest bits a wrong conversion would lose.
  const auto strange = [](int i, int j, int k) {
    const std::array values{0.0, 0.7, test::kNaN, double{INFINITY}, -double{INFINITY}, 3e38, -3e38, 1e-40};
    return (i + j + k) % 5 == 0 ? values[static_cast<std::size_t>(i + 3 * j + 5 * k) % values.size()] : 0.5;
  };
  const RippledBall floats(test::dense_field<float>(glm::ivec3(40), strange));
  const RenderOptions options{RippledBall::size()};
  const Rendered plain = test::draw_plainly<float>(floats.scene(), floats.camera(), options);
  with_every_target([&](const std::string& target) {
    expect_same(plain, test::draw(floats.scene(), floats.camera(), options), target);
  });
  const auto whole = [](int i, int j, int k) { return 4294967295.0 - (i * 7 + j * 5 + k * 3) % 11; };
  RippledBall large(test::dense_field<std::uint32_t>(glm::ivec3(40), whole));
  const std::array points{ControlPoint{4294967285.0, {1, 0, 0}, 0}, ControlPoint{4294967295.0, {0, 1, 1}, 0.4}};
  large.volume().transfer = TransferFunction::create(points).value();
  const Rendered plain_large = test::draw_plainly<std::uint32_t>(large.scene(), large.camera(), options);
  with_every_target([&](const std::string& target) {
    expect_same(plain_large, test::draw(large.scene(), large.camera(), options), target);
  });
}

TEST(Vectorized, MatchesPlainRaysFromFarAndInside) {
  const auto dense = test::dense_field<float>(glm::ivec3(40), &RippledBall::value);
  const RippledBall ball(test::sparse_copy<float>(dense, 0));
  for (const double distance : {3.0, 1e4, 1e9}) {
    Camera camera = ball.camera();
    camera.target = glm::dvec3(19.5);
    camera.eye = camera.target + glm::dvec3(0.3, -1, 0.2) * distance;
    camera.near_depth = distance / 4;
    camera.far_depth = 2 * distance;
    camera.fovy = std::min(1.0, 30 / distance);
    const RenderOptions options{RippledBall::size()};
    const Rendered plain = test::draw_plainly<float>(ball.scene(), camera, options);
    EXPECT_GT(plain.statistics.samples, 1000U) << distance;
    expect_same(plain, test::draw(ball.scene(), camera, options), std::to_string(distance));
  }
}

}  // namespace
}  // namespace isoextract::render
