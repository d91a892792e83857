// Compares GPU pictures with closed forms, and with pictures of the reference renderer.
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "unit/render/gpu_drawing.hpp"
#include "unit/render/plane_in_fog.hpp"

namespace isoextract::render {
namespace {

struct Compared {
  std::size_t off = 0;  // pixels
  RenderStatistics cpu;
  RenderStatistics gpu;
};

Compared compare(const Scene& scene, const Camera& camera, const RenderOptions& options) {
  const Rendered cpu = test::draw(scene, camera, options);
  const Rendered gpu = test::draw_on_gpu(scene, camera, options);
  return {test::pixels_off(cpu.picture, gpu.picture), cpu.statistics, gpu.statistics};
}

// Transforms: anisotropic and far from the origin, sheared, mirrored.
std::vector<field::Affine> transforms() {
  return {field::Affine{glm::dmat3(0.5, 0, 0, 0, 1, 0, 0, 0, 2), {1e6, -2e5, 3e4}},
          field::Affine{glm::dmat3(1, 0.3, 0, -0.4, 1, 0.2, 0, 0.5, 1), {-3, 2, 1}},
          field::Affine{glm::dmat3(0, 1.5, 0, 1, 0, 0, 0, 0, 1), {0, 0, 5}}};
}

// Cameras outside, and inside between samples.
std::vector<Camera> cameras(const Scene& scene, const PictureSize& size, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> angle(-180, 180);
  const field::Box box = *box_of(scene);
  std::vector<Camera> all{frame_box(box, {angle(engine), angle(engine) / 2.1}, UpAxis::z, size)};
  Camera within = frame_box(box, {angle(engine), angle(engine) / 3}, UpAxis::y, size);
  within.eye = within.target + 0.07 * (within.eye - within.target);
  within.near_depth = 1e-3 * within.unit();
  all.push_back(within);
  return all;
}

TEST(GpuPicture, MatchesClosedFormInSixCases) {
  expect_six_cases([](const auto&... parts) { return test::draw_on_gpu(parts...); }, 1e-4);
}

template <class T>
class GpuPictureOfSamples : public testing::Test {};
using SampleTypes = testing::Types<std::uint8_t, std::int16_t, std::uint32_t, field::Half, float, double>;
TYPED_TEST_SUITE(GpuPictureOfSamples, SampleTypes);

// Random samples that span more than one node of bricks along one axis, and a transfer function with a step.
TYPED_TEST(GpuPictureOfSamples, MatchesCpuForAnyPlacement) {
  const auto dense = test::random_field<TypeParam>({168, 24, 16}, 5, 100);
  const auto sparse = test::sparse_copy<TypeParam>(dense, 0);
  const std::array points{ControlPoint{20, {0.1, 0.9, 0.2}, 0}, ControlPoint{55, {0.1, 0.9, 0.2}, 0.1},
                          ControlPoint{55, {0.9, 0.2, 0.1}, 0.4}, ControlPoint{90, {0.9, 0.9, 1}, 0.6}};
  unsigned seed = 1;
  for (const field::Affine& place : transforms()) {
    for (const field::ScalarField* field : {&dense, &sparse}) {
      const Volume volume{field, place, TransferFunction::create(points).value(), 1.5};
      Scene scene;
      scene.volume = &volume;
      scene.background = {0.1, 0.2, 0.3, 0.5};
      RenderOptions options{{40, 30}};
      options.samples_per_voxel = 0.7;
      for (const Camera& camera : cameras(scene, options.size, ++seed)) {
        options.early_termination = seed % 2 == 0;
        const Compared both = compare(scene, camera, options);
        EXPECT_EQ(both.off, 0U) << seed;
        EXPECT_GT(both.gpu.rays, 50U);
        EXPECT_NEAR(double(both.gpu.rays), double(both.cpu.rays), 1e-3 * double(both.cpu.rays));
        EXPECT_NEAR(double(both.gpu.samples), double(both.cpu.samples), 1e-3 * double(both.cpu.samples));
      }
    }
  }
}

TEST(GpuPicture, SkipsEmptySpaceWithoutChange) {
  const auto dense = test::ball(64);
  const auto sparse = test::sparse_copy<float>(dense, 0);
  for (const field::ScalarField* field : {&dense, &sparse}) {
    const Volume volume{field, field->index_to_world, test::rising_transfer(0.2, 0.3), 1};
    Scene scene;
    scene.volume = &volume;
    RenderOptions options{{64, 48}};
    options.early_termination = false;
    const Camera camera = frame_box(*box_of(scene), {30, 10}, UpAxis::z, options.size);
    const Rendered skipping = test::draw_on_gpu(scene, camera, options);
    options.empty_space_skipping = false;
    const Rendered taking_all = test::draw_on_gpu(scene, camera, options);
    EXPECT_TRUE(test::same_bytes(skipping.picture.color, taking_all.picture.color));
    EXPECT_TRUE(test::same_bytes(skipping.picture.depth, taking_all.picture.depth));
    EXPECT_EQ(taking_all.statistics.samples_skipped, 0U);
    EXPECT_GT(skipping.statistics.samples_skipped, skipping.statistics.samples / 2);
    EXPECT_EQ(skipping.statistics.samples + skipping.statistics.samples_skipped, taking_all.statistics.samples);
    EXPECT_GT(skipping.statistics.bricks_skipped, skipping.statistics.bricks / 4);

    options.early_termination = true;
    const Rendered ending = test::draw_on_gpu(scene, camera, options);
    EXPECT_GT(ending.statistics.samples_terminated, 1000U);
    EXPECT_EQ(ending.statistics.samples + ending.statistics.samples_terminated, taking_all.statistics.samples);
    EXPECT_LE(test::largest_difference(ending.picture, taking_all.picture), options.termination);
  }
}

TEST(GpuPicture, DrawsVisibleTilesAndBackground) {
  // One leaf, a tile as large as two nodes, and a visible background.
  field::ScalarField field;
  field.source = "test field";
  const auto values = std::make_shared<std::vector<float>>(512, 0.9F);
  field::SparseSamples samples;
  samples.background = 0.3;
  samples.blocks = {{{-8, 0, 0}, values->data()}};
  samples.tiles = {{{0, 0, 0}, 256, 0.7}};
  samples.active_box = {{-8, 0, 0}, {255, 255, 255}};
  samples.owner = values;
  field.samples = samples;
  const std::array points{ControlPoint{0, {1, 0, 0}, 0.01}, ControlPoint{1, {0, 0.3, 1}, 0.03}};
  const Volume volume{&field, field.index_to_world, TransferFunction::create(points).value(), 8};
  Scene scene;
  scene.volume = &volume;
  RenderOptions options{{32, 24}};
  options.samples_per_voxel = 0.25;
  for (const Camera& camera : cameras(scene, options.size, 3)) EXPECT_EQ(compare(scene, camera, options).off, 0U);
}

TEST(GpuPicture, HidesNan) {
  auto field = test::dense_field<float>({17, 9, 9}, [](int i, int j, int k) {
    return i % 5 == 2 && j % 4 == 1 ? test::kNaN : k == 3 ? std::numeric_limits<double>::infinity() : i / 16.0;
  });
  const Volume volume{&field, field.index_to_world, test::rising_transfer(0.1, 0.5), 1};
  Scene scene;
  scene.volume = &volume;
  RenderOptions options{{48, 32}};
  for (const Camera& camera : cameras(scene, options.size, 8)) {
    const Compared both = compare(scene, camera, options);
    EXPECT_EQ(both.off, 0U);
    EXPECT_EQ(both.cpu.samples, both.gpu.samples);
  }
}

// Intersecting surfaces: smooth and flat, of one and of many colors, opaque and transparent.
class Spheres {
 public:
  explicit Spheres(double opacity) {
    meshes_.push_back(test::sphere(24, true, "smooth", {1e5, 0, 0}));
    meshes_.push_back(test::sphere(12, false, "flat", {1e5 + 0.4, 0.3, 0.2}));
    meshes_.push_back(test::sphere(16, true, "painted", {1e5 - 0.5, -0.2, 0.3}));
    mesh::Attribute paint;
    paint.name = "color";
    paint.role = mesh::AttributeRole::color;
    paint.type = mesh::ComponentType::u8;
    paint.components = 4;
    paint.normalized = true;
    std::vector<std::byte> bytes;
    for (std::size_t v = 0; v < meshes_[2].positions.size(); ++v) {
      for (const std::size_t c : {v % 256, (3 * v) % 256, 255 - v % 256, 100 + v % 150})
        bytes.push_back(static_cast<std::byte>(c));
    }
    paint.values = test::buffer_of(bytes);
    meshes_[2].attributes.push_back(std::move(paint));
    scene_.surfaces = {{&meshes_[0], {0.8, 0.3, 0.1}, 1},
                       {&meshes_[1], {0.2, 0.7, 0.4}, opacity, Shading::flat},
                       {&meshes_[2], {1, 1, 1}, opacity, Shading::smooth, true}};
    scene_.lights = {Light{{-0.4, 0.6, 0.7}}, Light{{1, 0, 0.2}, false, {0.3, 0.4, 0.9}}};
    scene_.background = {0.4, 0.4, 0.4, 1};
  }
  Scene& scene() { return scene_; }

 private:
  std::vector<mesh::Mesh> meshes_;
  Scene scene_;
};

TEST(GpuPicture, DrawsSurfacesLikeCpu) {
  for (const double opacity : {1.0, 0.35}) {
    Spheres spheres(opacity);
    const RenderOptions options{{160, 120}};
    for (const Camera& camera : cameras(spheres.scene(), options.size, 4)) {
      const Rendered cpu = test::draw(spheres.scene(), camera, options);
      const Rendered gpu = test::draw_on_gpu(spheres.scene(), camera, options);
      // Pixels whose centers are on an edge may see a neighboring triangle.
      EXPECT_LE(test::pixels_off(cpu.picture, gpu.picture), gpu.picture.pixels() / 400) << opacity;
      EXPECT_NEAR(double(gpu.statistics.fragments), double(cpu.statistics.fragments),
                  0.01 * double(cpu.statistics.fragments));
      std::size_t depths_off = 0;
      std::size_t normals_off = 0;
      for (std::size_t i = 0; i < gpu.picture.pixels(); ++i) {
        const float a = cpu.picture.depth[i];
        const float b = gpu.picture.depth[i];
        depths_off += a == b || std::abs(a - b) < 1e-5F * a ? 0 : 1;
        normals_off += glm::length(cpu.picture.normals[i] - gpu.picture.normals[i]) < 1e-3F ? 0 : 1;
      }
      EXPECT_LE(depths_off, gpu.picture.pixels() / 200);
      EXPECT_LE(normals_off, gpu.picture.pixels() / 200);
    }
  }
}

TEST(GpuPicture, DrawsSurfacesInVolumeLikeCpu) {
  auto field = test::ball(24);
  for (const double opacity : {1.0, 0.35}) {
    Spheres spheres(opacity);
    const Volume volume{&field, {glm::dmat3(0.1), {1e5 - 1.2, -1.2, -1.2}}, test::rising_transfer(0.1, 0.6), 1};
    spheres.scene().volume = &volume;
    RenderOptions options{{120, 90}};
    for (const double samples : {1.0, 5.0}) {
      options.samples_per_voxel = samples;
      for (const Camera& camera : cameras(spheres.scene(), options.size, 6)) {
        EXPECT_LE(compare(spheres.scene(), camera, options).off, 120U * 90 / 400) << opacity << " " << samples;
      }
    }
  }
}

TEST(GpuPicture, SortsManyTransparentSurfaces) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> part(0, 1);
  std::vector<double> places;
  for (int n = 0; n < 70; ++n) places.push_back(n / 10.0);
  std::ranges::shuffle(places, engine);
  std::vector<mesh::Mesh> layers;
  for (const double y : places) layers.push_back(test::rectangle(y, -1 - part(engine), 1 + part(engine), -2, 2));
  Scene scene;
  for (const mesh::Mesh& layer : layers) {
    scene.surfaces.push_back({&layer, {part(engine), part(engine), part(engine)}, 0.02 + 0.1 * part(engine)});
  }
  // Of two coincident surfaces the first in the scene is in front.
  layers.push_back(test::rectangle(-0.5, -1, 1, -1, 1));
  scene.surfaces.push_back({&layers.back(), {1, 0, 0}, 0.5});
  scene.surfaces.push_back({&layers.back(), {0, 1, 0}, 0.5});
  // push_back() may have moved the earlier layers, so sets the pointers again.
  for (std::size_t n = 0; n < layers.size(); ++n) scene.surfaces[n].mesh = &layers[n];
  scene.surfaces.back().mesh = &layers.back();
  scene.shading = test::unlit();
  RenderOptions options{{64, 48}};
  const Camera camera = frame_box(*box_of(scene), {12, 7}, UpAxis::z, options.size);
  const Compared both = compare(scene, camera, options);
  EXPECT_LE(both.off, 64U * 48 / 200);
  EXPECT_GT(both.gpu.fragments, 15000U);
}

}  // namespace
}  // namespace isoextract::render
