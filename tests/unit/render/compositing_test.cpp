// Compares a box of uniform density and a plane with closed forms.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "unit/render/plane_in_fog.hpp"

namespace isoextract::render {
namespace {

TEST(Compositing, MatchesClosedFormInSixCases) {
  expect_six_cases([](const auto&... parts) { return test::draw(parts...); }, 1e-5);
}

TEST(Compositing, UniformDensityIsIndependentOfSampleCount) {
  const PlaneInFog setup(3.37, 0.4);
  for (const double samples : {0.3, 1.7, 9.0}) {
    RenderOptions options{PlaneInFog::size()};
    options.early_termination = false;
    options.samples_per_voxel = samples;
    std::map<Case, int> met;
    EXPECT_LT(difference(setup, test::draw(setup.scene(), setup.camera(), options).picture, met), 2e-5) << samples;
  }
}

TEST(Compositing, OpacityIsIndependentOfStep) {
  // A layer one unit thick has the opacity of the transfer function.
  const auto field = test::dense_field<float>(glm::ivec3(5), [](int, int, int) { return 1; });
  Volume volume{&field, field::scaling(glm::dvec3(0.5)), test::constant_transfer({1, 1, 1}, 0.3), 2};
  Scene scene;
  scene.volume = &volume;
  Camera camera;
  camera.eye = {1, -10, 1};
  camera.target = {1, 0, 1};
  for (const double samples : {0.5, 1.0, 7.3}) {
    RenderOptions options{{1, 1}};
    options.samples_per_voxel = samples;
    const Rendered rendered = test::draw(scene, camera, options);
    EXPECT_NEAR(rendered.picture.color[0].a, 0.3, 1e-6);
    EXPECT_EQ(rendered.statistics.samples, static_cast<std::uint64_t>(std::ceil(4 * samples - 1e-9)));
  }
}

TEST(Compositing, SetsDepthWhereHalfOfLightIsLeft) {
  // The plane of opacity 0.4 in the fog does not hide half of the light by itself.
  const PlaneInFog setup(3.37, 0.4);
  RenderOptions options{PlaneInFog::size()};
  options.samples_per_voxel = 16;
  const Picture picture = test::draw(setup.scene(), setup.camera(), options).picture;
  int in_fog = 0;
  int nothing = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const std::size_t i = test::pixel_of(picture, x, y);
      const Expected expected = setup.expected(x, y);
      const test::WorldRay ray = test::ray_of(setup.camera(), PlaneInFog::size(), x, y);
      if (expected.met == Case::neither) {
        EXPECT_EQ(picture.depth[i], std::numeric_limits<float>::infinity());
        ++nothing;
      }
      if (expected.met == Case::surface_only) {
        EXPECT_NEAR(picture.depth[i], (3.37 - ray.eye.y) / ray.along.y, 1e-5);
        EXPECT_NEAR(glm::length(picture.normals[i] - glm::vec3(0, -1, 0)), 0, 1e-6);
      }
      if (expected.met == Case::volume_only && picture.color[i].a == 1 && std::isfinite(picture.depth[i])) {
        double enter = 0;
        for (int axis = 0; axis < 3; ++axis) {
          enter = std::max(enter, std::min(-ray.eye[axis] / ray.along[axis], (8 - ray.eye[axis]) / ray.along[axis]));
        }
        EXPECT_NEAR(picture.depth[i], enter + std::log(2.0) / kSigma / glm::length(ray.along), 1.0 / 16);
        EXPECT_EQ(picture.normals[i], glm::vec3(0));
        ++in_fog;
      }
    }
  }
  EXPECT_GT(in_fog, 50);
  EXPECT_GT(nothing, 50);
}

TEST(Compositing, SortsTransparentSurfacesByDepth) {
  const mesh::Mesh near = test::rectangle(0, -5, 5, -5, 5);
  const mesh::Mesh middle = test::rectangle(1, -5, 5, -5, 5);
  const mesh::Mesh far = test::rectangle(2, -5, 5, -5, 5);
  Camera camera;
  camera.eye = {0, -4, 0};
  Scene scene;
  scene.shading = test::unlit();
  const Surface red{&near, {1, 0, 0}, 0.5};
  const Surface green{&middle, {0, 1, 0}, 0.25};
  const Surface blue{&far, {0, 0, 1}, 1};
  std::array order{red, green, blue};
  for (const std::array<int, 3>& turn : {std::array{0, 1, 2}, std::array{2, 1, 0}, std::array{1, 2, 0}}) {
    scene.surfaces.clear();
    for (const int i : turn) scene.surfaces.push_back(order[static_cast<std::size_t>(i)]);
    const Picture picture = test::draw(scene, camera, {{3, 3}}).picture;
    for (const glm::vec4& pixel : picture.color) {
      EXPECT_NEAR(glm::length(pixel - glm::vec4(0.5, 0.125, 0.375, 1)), 0, 1e-6);
    }
  }
  // At equal depth, the surface that comes first in the scene is in front.
  scene.surfaces = {{&near, {1, 0, 0}, 1}, {&near, {0, 1, 0}, 1}};
  EXPECT_EQ(test::draw(scene, camera, {{1, 1}}).picture.color[0], glm::vec4(1, 0, 0, 1));
}

}  // namespace
}  // namespace isoextract::render
