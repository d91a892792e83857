#include "render/scene.hpp"

#include <functional>

#include "unit/render/drawing.hpp"

namespace isoextract::render {
namespace {

TEST(Scene, BoundsEverythingVisible) {
  const auto dense = test::dense_field<float>({4, 5, 6}, [](int, int, int) { return 1; });
  EXPECT_EQ(volume_box(dense).value(), (field::Box{{0, 0, 0}, {3, 4, 5}}));
  const auto sparse = test::sparse_copy<float>(test::ball(40), 0);
  EXPECT_EQ(volume_box(sparse).value(), (field::Box{{-1, -1, -1}, {40, 40, 40}}));

  const mesh::Mesh rectangle = test::rectangle(7, -3, 1, -2, 2);
  Volume volume{&dense, field::scaling(glm::dvec3(2)), {}, 1};
  Scene scene;
  scene.volume = &volume;
  scene.surfaces.push_back({&rectangle});
  EXPECT_EQ(box_of(scene).value(), (field::Box{{-3, 0, -2}, {6, 8, 10}}));
  const auto nothing = box_of(Scene());
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, ErrorCode::input);
}

TEST(Scene, RefusesFlatAndEmptyVolumes) {
  const auto flat = test::dense_field<float>({4, 1, 6}, [](int, int, int) { return 1; });
  const auto refused = volume_box(flat);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "test field: expected at least two samples along each axis, found 4 x 1 x 6");
  field::ScalarField empty;
  empty.samples = field::SparseSamples();
  EXPECT_EQ(volume_box(empty).error().code, ErrorCode::empty_grid);
}

TEST(Scene, RefusesInvalidScenes) {
  const mesh::Mesh rectangle = test::rectangle(7, -3, 1, -2, 2);
  const auto dense = test::dense_field<float>({4, 5, 6}, [](int, int, int) { return 1; });
  Volume volume{&dense, {}, {}, 1};
  const auto kind_of = [&](const std::function<void(Scene&, RenderOptions&)>& change) {
    Scene scene;
    scene.volume = &volume;
    scene.surfaces.push_back({&rectangle});
    RenderOptions options;
    change(scene, options);
    const auto checked = check(scene, Camera(), options);
    volume = {&dense, {}, {}, 1};
    return checked ? 0 : exit_code_of(checked.error().code);
  };
  const int usage = exit_code_of(ErrorCode::usage);
  const int input = exit_code_of(ErrorCode::input);
  EXPECT_EQ(kind_of([](Scene&, RenderOptions&) {}), 0);
  EXPECT_EQ(kind_of([](Scene& s, RenderOptions&) { s.surfaces[0].opacity = 0; }), usage);
  EXPECT_EQ(kind_of([](Scene& s, RenderOptions&) { s.surfaces[0].color.g = -1; }), usage);
  EXPECT_EQ(kind_of([](Scene& s, RenderOptions&) { s.surfaces[0].vertex_colors = true; }), input);
  EXPECT_EQ(kind_of([](Scene& s, RenderOptions&) { s.lights[0].towards = glm::dvec3(0); }), usage);
  EXPECT_EQ(kind_of([](Scene& s, RenderOptions&) { s.lights.resize(9); }), usage);
  EXPECT_EQ(kind_of([](Scene& s, RenderOptions&) { s.shading.shininess = 0; }), usage);
  EXPECT_EQ(kind_of([](Scene& s, RenderOptions&) { s.background.a = 2; }), usage);
  EXPECT_EQ(kind_of([&](Scene&, RenderOptions&) { volume.unit_length = 0; }), usage);
  EXPECT_EQ(kind_of([&](Scene&, RenderOptions&) { volume.index_to_world.linear[1] = glm::dvec3(0); }), input);
  EXPECT_EQ(kind_of([](Scene&, RenderOptions& o) { o.size = {0, 5}; }), usage);
  EXPECT_EQ(kind_of([](Scene&, RenderOptions& o) { o.size = {5, 16385}; }), usage);
  EXPECT_EQ(kind_of([](Scene&, RenderOptions& o) { o.samples_per_voxel = 0; }), usage);
  EXPECT_EQ(kind_of([](Scene&, RenderOptions& o) { o.termination = 1; }), usage);
}

TEST(Scene, StepsByShortestVoxelEdge) {
  const auto dense = test::dense_field<float>({4, 5, 6}, [](int, int, int) { return 1; });
  Volume volume{&dense, field::scaling({3, 0.5, 7}), {}, 1};
  RenderOptions options;
  options.samples_per_voxel = 2;
  EXPECT_EQ(step_of(volume, options), 0.25);
}

}  // namespace
}  // namespace isoextract::render
