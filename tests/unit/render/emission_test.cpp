// Tests volumes that emit light on both backends: closed forms, boxes and placements that differ, skipping.
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "render/black_body.hpp"
#include "render/visible_box.hpp"
#include "unit/render/gpu_drawing.hpp"

namespace isoextract::render {
namespace {

constexpr double kUnit = 2;       // length to which opacities refer
constexpr double kOpacity = 0.3;  // of a layer of this length
constexpr double kKelvin = 2000;
const glm::dvec3 kColor(0.2, 0.5, 0.9);

double sigma() { return -std::log1p(-kOpacity) / kUnit; }  // per world unit
glm::dvec3 light_of(double kelvin) {                       // per world unit
  const TransferFunction function = emission_function(std::nullopt).value();
  return glm::dvec3(function.lookup(function.position(kelvin))) / kUnit;
}

using Draw = std::function<Rendered(const Scene&, const Camera&, const RenderOptions&)>;
struct Backend {
  std::string name;
  Draw draw;
  double tolerance;
};
std::vector<Backend> backends() {
  return {{"cpu", [](const auto&... parts) { return test::draw(parts...); }, 1e-6},
          {"gpu", [](const auto&... parts) { return test::draw_on_gpu(parts...); }, 1e-4}};
}

// A uniform density, and a uniform temperature in another box along y. One ray goes through the middle of both.
class Slabs {
 public:
  // The density extends from y = 0 to 6, the temperature from `first` to `last`, which are whole numbers.
  Slabs(int first, int last, double density = 1)
      : density_(test::dense_field<float>({5, 7, 5}, [&](int, int, int) { return density; })),
        heat_(test::dense_field<float>({5, last - first + 1, 5}, [](int, int, int) { return kKelvin; })),
        emission_{&heat_, field::Affine{glm::dmat3(1), {0, first, 0}}, emission_function(std::nullopt).value()} {
    const std::array points{ControlPoint{0, kColor, 0}, ControlPoint{1, kColor, kOpacity}};
    volume_ = {&density_, {}, TransferFunction::create(points).value(), kUnit, &emission_};
    scene_.volume = &volume_;
    camera_.eye = {2, -10, 2};
    camera_.target = {2, 0, 2};
    camera_.near_depth = 1;
  }
  Slabs(const Slabs&) = delete;
  Slabs& operator=(const Slabs&) = delete;

  Scene& scene() { return scene_; }
  Volume& volume() { return volume_; }
  const Camera& camera() const { return camera_; }

 private:
  field::ScalarField density_;
  field::ScalarField heat_;
  Volume emission_;
  Volume volume_;
  Scene scene_;
  Camera camera_;
};

RenderOptions options_of_one_ray() {
  RenderOptions options{{1, 1}};
  options.early_termination = false;
  return options;
}

void expect_color(const Backend& backend, Slabs& slabs, const glm::dvec3& color, double alpha,
                  const std::string& what) {
  for (const double samples : {0.3, 1.0, 5.7}) {
    for (const bool skipping : {false, true}) {
      RenderOptions options = options_of_one_ray();
      options.samples_per_voxel = samples;
      options.empty_space_skipping = skipping;
      const Rendered drawn = backend.draw(slabs.scene(), slabs.camera(), options);
      ASSERT_EQ(drawn.picture.pixels(), 1U);
      const glm::dvec4 found(drawn.picture.color[0]);
      const std::string where = backend.name + ", " + what + ", " + std::to_string(samples);
      EXPECT_NEAR(glm::length(glm::dvec3(found) - color), 0, backend.tolerance * std::max(1.0, glm::length(color)))
          << where;
      EXPECT_NEAR(found.a, alpha, backend.tolerance) << where;
      EXPECT_EQ(drawn.statistics.rays, 1U);
    }
  }
}

TEST(Emission, MatchesClosedForm) {
  const double s = sigma();
  const glm::dvec3 e = light_of(kKelvin);
  ASSERT_GT(e.r, 0.01);
  const auto taken = [&](double length) { return 1 - std::exp(-s * length); };
  for (const Backend& backend : backends()) {
    Slabs same(0, 6);
    expect_color(backend, same, (kColor + e / s) * taken(6), taken(6), "in the same box");
    Slabs clear(0, 6, 0);
    expect_color(backend, clear, e * 6.0, 0, "without density");
    Slabs behind(8, 12);
    expect_color(backend, behind, kColor * taken(6) + std::exp(-s * 6) * e * 4.0, taken(6), "behind the smoke");
    Slabs before(-5, -2);
    expect_color(backend, before, e * 3.0 + kColor * taken(6), taken(6), "before the smoke");
    Slabs within(2, 3);
    expect_color(backend, within, kColor * taken(6) + std::exp(-s * 2) * e / s * taken(1), taken(6),
                 "within the smoke");
    Slabs through(4, 9);
    expect_color(backend, through, kColor * taken(6) + std::exp(-s * 4) * e / s * taken(2) + std::exp(-s * 6) * e * 3.0,
                 taken(6), "half in the smoke");
  }
}

TEST(Emission, IsHiddenBySurfaces) {
  const double s = sigma();
  const glm::dvec3 e = light_of(kKelvin);
  const mesh::Mesh plane = test::rectangle(2.3, -9, 9, -9, 9);
  const auto taken = [&](double length) { return 1 - std::exp(-s * length); };
  for (const Backend& backend : backends()) {
    for (const double opacity : {1.0, 0.4}) {
      Slabs slabs(0, 6);
      slabs.scene().shading = test::unlit();
      slabs.scene().surfaces = {{&plane, {0.3, 0.2, 0.1}, opacity}};
      const glm::dvec3 gas = kColor + e / s;
      const double left = std::exp(-s * 2.3);
      expect_color(
          backend, slabs,
          gas * taken(2.3) + left * opacity * glm::dvec3(0.3, 0.2, 0.1) + left * (1 - opacity) * gas * taken(3.7),
          1 - left * (1 - opacity) * std::exp(-s * 3.7), "with a plane");
      Slabs clear(0, 6, 0);
      clear.scene().shading = test::unlit();
      clear.scene().surfaces = slabs.scene().surfaces;
      expect_color(backend, clear, e * 2.3 + opacity * glm::dvec3(0.3, 0.2, 0.1) + (1 - opacity) * e * 3.7, opacity,
                   "with a plane in clear gas");
    }
  }
}

TEST(Emission, ColdFieldChangesNoBit) {
  const field::ScalarField ball = test::ball(40);
  const auto cold =
      test::dense_field<float>(glm::ivec3(40), [](int i, int, int) { return i % 3 == 0 ? test::kNaN : 20 * i; });
  const Volume emission{&cold, {}, emission_function(std::nullopt).value()};
  Volume volume{&ball, {}, test::rising_transfer(0.1, 0.3), 1};
  Scene scene;
  scene.volume = &volume;
  const Camera camera = frame_box({glm::dvec3(0), glm::dvec3(39)}, {25, 15}, UpAxis::z, {70, 50});
  const Rendered plain = test::draw(scene, camera, {{70, 50}});
  const Rendered plain_on_gpu = test::draw_on_gpu(scene, camera, {{70, 50}});
  volume.emission = &emission;
  const Rendered drawn = test::draw(scene, camera, {{70, 50}});
  EXPECT_TRUE(test::same_picture(plain.picture, drawn.picture));
  EXPECT_EQ(plain.statistics.samples, drawn.statistics.samples);
  EXPECT_EQ(drawn.statistics.bricks, 2 * plain.statistics.bricks);
  EXPECT_EQ(test::pixels_off(plain_on_gpu.picture, test::draw_on_gpu(scene, camera, {{70, 50}}).picture), 0U);
}

// A soft ball of smoke, and a hot ball beside and in it on a grid of its own: coarser, turned and moved.
class Fire {
 public:
  explicit Fire(bool sparse,
                const field::Affine& place = {glm::dmat3(1.5, 0.6, 0, -0.6, 1.5, 0, 0.1, 0, 1.6), {9, -6, 3}})
      : smoke_(test::ball(40)), heat_(hot_ball(24)) {
    if (sparse) {
      smoke_ = test::sparse_copy<float>(smoke_, 0);
      heat_ = test::sparse_copy<float>(heat_, 0);
    }
    emission_ = {&heat_, place, emission_function(std::nullopt).value()};
    volume_ = {&smoke_, {}, test::rising_transfer(0.1, 0.1), 1, &emission_};
    scene_.volume = &volume_;
    plane_ = test::rectangle(19.3, 5, 35, 0, 39);
    scene_.surfaces = {{&plane_, {0.9, 0.8, 0.1}, 0.5}};
  }
  Fire(const Fire&) = delete;
  Fire& operator=(const Fire&) = delete;

  static field::ScalarField hot_ball(int side) {
    return test::dense_field<float>(glm::ivec3(side), [&](int i, int j, int k) {
      const double r = glm::length(glm::dvec3(i, j, k) - (side - 1) / 2.0) / side;
      return i == side / 2 && j == 3 ? test::kNaN : r < 0.4 ? 2600 - 4000 * r : 0;
    });
  }
  Scene& scene() { return scene_; }
  Volume& volume() { return volume_; }
  Camera camera(double azimuth) const { return frame_box(*box_of(scene_), {azimuth, 15}, UpAxis::z, {61, 47}); }

 private:
  field::ScalarField smoke_;
  field::ScalarField heat_;
  mesh::Mesh plane_;
  Volume emission_;
  Volume volume_;
  Scene scene_;
};

std::uint64_t slabs_of(const RenderStatistics& statistics) {
  return statistics.samples + statistics.samples_skipped + statistics.samples_terminated;
}

TEST(Emission, SkippingChangesNoBit) {
  for (const bool sparse : {false, true}) {
    Fire fire(sparse);
    for (const double azimuth : {20.0, 130.0, 260.0}) {
      RenderOptions options{{61, 47}};
      options.early_termination = false;
      options.empty_space_skipping = false;
      const Rendered all = test::draw(fire.scene(), fire.camera(azimuth), options);
      const Rendered all_on_gpu = test::draw_on_gpu(fire.scene(), fire.camera(azimuth), options);
      options.empty_space_skipping = true;
      const Rendered skipped = test::draw(fire.scene(), fire.camera(azimuth), options);
      EXPECT_TRUE(test::same_picture(all.picture, skipped.picture)) << sparse << azimuth;
      EXPECT_EQ(all.statistics.samples_skipped, 0U);
      EXPECT_GT(skipped.statistics.samples_skipped, all.statistics.samples / 10);
      EXPECT_EQ(slabs_of(skipped.statistics), all.statistics.samples);
      EXPECT_GT(skipped.statistics.bricks_skipped, 0U);
      const Rendered skipped_on_gpu = test::draw_on_gpu(fire.scene(), fire.camera(azimuth), options);
      EXPECT_TRUE(test::same_picture(all_on_gpu.picture, skipped_on_gpu.picture)) << sparse << azimuth;
      EXPECT_EQ(all_on_gpu.statistics.samples, all.statistics.samples);
      EXPECT_EQ(slabs_of(skipped_on_gpu.statistics), all.statistics.samples);
    }
  }
}

TEST(Emission, GpuMatchesCpu) {
  for (const bool sparse : {false, true}) {
    for (const field::Affine& place :
         {field::Affine{}, field::Affine{glm::dmat3(-1, 0, 0, 0, 2, 0, 0, 0, 1), {45, -3, 10}},
          field::Affine{glm::dmat3(1, 0.3, 0, -0.4, 1, 0.2, 0, 0.5, 1), {60, 2, 1}}}) {
      Fire fire(sparse, place);
      fire.scene().background = {0.1, 0.2, 0.3, 0.5};
      for (const bool surfaces : {true, false}) {
        if (!surfaces) fire.scene().surfaces.clear();
        const Rendered cpu = test::draw(fire.scene(), fire.camera(50), {{61, 47}});
        const Rendered gpu = test::draw_on_gpu(fire.scene(), fire.camera(50), {{61, 47}});
        EXPECT_LE(test::pixels_off(cpu.picture, gpu.picture), surfaces ? cpu.picture.pixels() / 300 : 0U) << sparse;
        float brightest = 0;
        for (const glm::vec4& color : cpu.picture.color) brightest = std::max(brightest, color.r);
        EXPECT_GT(brightest, 0.3F);
      }
    }
  }
}

TEST(Emission, FinerStepsConverge) {
  Fire fire(false);
  RenderOptions options{{61, 47}};
  options.samples_per_voxel = 1;
  const Rendered coarse = test::draw(fire.scene(), fire.camera(20), options);
  options.samples_per_voxel = 8;
  const Rendered fine = test::draw(fire.scene(), fire.camera(20), options);
  EXPECT_LT(test::largest_difference(coarse.picture, fine.picture), 0.03F);
}

TEST(Emission, IsKeptWithItsVolume) {
  Fire fire(true);
  const auto on_cpu = make_cpu_renderer();
  for (Renderer* renderer : {on_cpu.get(), test::kGpuRenderers->find()}) {
    ASSERT_NE(renderer, nullptr);
    const Context context;
    const auto draw = [&](double azimuth) {
      return renderer->draw(fire.scene(), fire.camera(azimuth), {{61, 47}}, context).value();
    };
    const Rendered anew = draw(80);
    const std::uint64_t before = context.memory().reserved();
    renderer->keep(&fire.volume());
    draw(0);
    EXPECT_GT(context.memory().reserved(), before);
    const Rendered kept = draw(80);
    EXPECT_TRUE(kept.reused_volume);
    EXPECT_TRUE(test::same_picture(anew.picture, kept.picture));
    EXPECT_EQ(anew.statistics, kept.statistics);
    renderer->keep(nullptr);
  }
}

TEST(Emission, BoxesEncloseBothFields) {
  Slabs slabs(4, 9);
  const field::Box box = box_of(slabs.scene()).value();
  EXPECT_EQ(box.min, glm::dvec3(0));
  EXPECT_EQ(box.max, glm::dvec3(4, 9, 4));
  Slabs clear(8, 9, 0);
  const field::Box visible = visible_box_of(clear.scene(), Context()).value();
  EXPECT_EQ(visible.min, glm::dvec3(0, 8, 0));
  EXPECT_EQ(visible.max, glm::dvec3(4, 9, 4));
}

TEST(Emission, CoverLightRaisesAlpha) {
  Picture picture = make_picture(3, 1, Context()).value();
  picture.color[0] = {0.25F, 0.5F, 0.125F, 0.125F};
  picture.color[1] = {0.25F, 0.5F, 0.125F, 0.75F};
  picture.color[2] = {7, 0, 0, 0};
  cover_light(picture);
  EXPECT_EQ(picture.color[0], glm::vec4(0.25F, 0.5F, 0.125F, 0.5F));
  EXPECT_EQ(picture.color[1], glm::vec4(0.25F, 0.5F, 0.125F, 0.75F));
  EXPECT_EQ(picture.color[2], glm::vec4(7, 0, 0, 1));
}

TEST(Emission, SingularPlacementIsRefused) {
  Slabs slabs(0, 6);
  Volume emission = *slabs.volume().emission;
  emission.index_to_world.linear = glm::dmat3(0);
  slabs.volume().emission = &emission;
  const auto refused = make_cpu_renderer()->draw(slabs.scene(), slabs.camera(), options_of_one_ray(), Context());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::input);
}

}  // namespace
}  // namespace isoextract::render
