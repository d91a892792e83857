#include "render/camera.hpp"

#include <cmath>
#include <numbers>

#include "unit/render/drawing.hpp"

namespace isoextract::render {
namespace {

constexpr PictureSize kSize{64, 48};

Camera tilted() { return frame_box({{-1, -2, -3}, {5, 4, 3}}, {33, 21}, UpAxis::z, kSize); }

TEST(Camera, DirectionsMatchClipMatrix) {
  const Camera camera = tilted();
  const field::Affine world = camera.world_from_view();
  for (const auto& [x, y] : {std::pair{0, 0}, std::pair{63, 0}, std::pair{0, 47}, std::pair{30, 17}}) {
    const glm::dvec3 p = world(2.5 * direction_through(camera, kSize, x + 0.5, y + 0.5));
    const glm::dvec4 clip = camera.clip_from_world(kSize) * glm::dvec4(p, 1);
    EXPECT_NEAR((clip.x / clip.w + 1) / 2 * kSize.width, x + 0.5, 1e-9);
    EXPECT_NEAR((1 - clip.y / clip.w) / 2 * kSize.height, y + 0.5, 1e-9);
    EXPECT_NEAR(clip.w, 2.5, 1e-12);  // the depth
  }
}

TEST(Camera, ViewAndWorldMapsAreInverses) {
  const Camera camera = tilted();
  const glm::dvec3 p(0.3, -7, 2);
  EXPECT_NEAR(glm::length(camera.world_from_view()(camera.view_from_world()(p)) - p), 0, 1e-12);
  EXPECT_NEAR(glm::length(camera.view_from_world()(camera.target) - glm::dvec3(0, 0, -1)), 0, 1e-12);
}

TEST(Camera, FramesWholeBoxFromEveryAngle) {
  const field::Box box{{10, -4, 3}, {13, -3, 11}};
  for (const UpAxis up : {UpAxis::x, UpAxis::y, UpAxis::z}) {
    for (const double azimuth : {0.0, 50.0, 200.0}) {
      for (const double elevation : {-90.0, -30.0, 0.0, 90.0}) {
        for (const PictureSize size : {PictureSize{90, 30}, PictureSize{30, 90}}) {
          const Camera camera = frame_box(box, {azimuth, elevation}, up, size);
          ASSERT_TRUE(camera.check());
          for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec4 clip =
                camera.clip_from_world(size) *
                glm::dvec4((corner & 1) != 0 ? 13 : 10, (corner & 2) != 0 ? -3 : -4, (corner & 4) != 0 ? 11 : 3, 1);
            for (int axis = 0; axis < 3; ++axis) EXPECT_LE(std::abs(clip[axis]), clip.w);
          }
        }
      }
    }
  }
}

TEST(Camera, PlacesEyeByAzimuthAndElevation) {
  const field::Box box{{-1, -1, -1}, {1, 1, 1}};
  const auto eye = [&](double azimuth, double elevation, UpAxis up) {
    return frame_box(box, {azimuth, elevation, 5}, up, kSize).eye;
  };
  const auto near = [](const glm::dvec3& a, const glm::dvec3& b) { return glm::length(a - b) < 1e-9; };
  EXPECT_TRUE(near(eye(0, 0, UpAxis::z), {0, -5, 0}));
  EXPECT_TRUE(near(eye(90, 0, UpAxis::z), {5, 0, 0}));
  EXPECT_TRUE(near(eye(0, 90, UpAxis::z), {0, 0, 5}));
  EXPECT_TRUE(near(eye(0, 0, UpAxis::y), {0, 0, 5}));
  EXPECT_TRUE(near(eye(90, 0, UpAxis::y), {5, 0, 0}));
  EXPECT_TRUE(near(eye(90, 0, UpAxis::x), {0, -5, 0}));
  EXPECT_TRUE(near(eye(0, -90, UpAxis::x), {-5, 0, 0}));
  ViewAngles from_behind{0, 0, 5};
  from_behind.front = 180;
  EXPECT_TRUE(near(frame_box(box, from_behind, UpAxis::z, kSize).eye, {0, 5, 0}));
}

TEST(Camera, FramesFillPicture) {
  const field::Box box{{-1, -2, -3}, {4, 5, 6}};
  const PictureSize size{400, 300};
  const auto filled = [&](const Camera& camera) {
    const PixelBox seen = pixels_of(camera, size, {}, box);
    return std::max((seen.max.x - seen.min.x) / 400.0, (seen.max.y - seen.min.y) / 300.0);
  };
  for (const double elevation : {-90.0, 0.0, 20.0}) {
    double most = 0;
    double distance = 0;
    for (int azimuth = 0; azimuth < 360; azimuth += 5) {
      const ViewAngles angles{double(azimuth), elevation};
      const double closely = filled(frame_box_closely(box, angles, UpAxis::z, size, 0.5));
      EXPECT_LT(closely, 0.92) << azimuth << ' ' << elevation;  // a margin of a tenth
      EXPECT_GT(closely, 0.7) << azimuth << ' ' << elevation;
      const Camera turned = frame_turn(box, angles, UpAxis::z, size, 0.5);
      most = std::max(most, filled(turned));
      if (azimuth == 0) distance = turned.unit();
      EXPECT_NEAR(turned.unit(), distance, 1e-9);
      EXPECT_LE(distance, frame_box(box, angles, UpAxis::z, size, 0.5).unit() * (1 + 1e-12));
    }
    EXPECT_GT(most, 0.8) << elevation;
    EXPECT_LT(most, 1) << elevation;
  }
}

TEST(Camera, BoundsVisiblePixelsTightly) {
  const Camera camera = tilted();
  const field::Box box{{0, 0, 0}, {2, 1, 1}};
  const PixelBox found = pixels_of(camera, kSize, {}, box);
  ASSERT_FALSE(found.empty());
  glm::dvec2 low(1e9);
  glm::dvec2 high(-1e9);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec4 clip =
        camera.clip_from_world(kSize) *
        glm::dvec4((corner & 1) != 0 ? 2 : 0, (corner & 2) != 0 ? 1 : 0, (corner & 4) != 0 ? 1 : 0, 1);
    const glm::dvec2 at((clip.x / clip.w + 1) / 2 * kSize.width, (1 - clip.y / clip.w) / 2 * kSize.height);
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  EXPECT_LE(found.min.x, low.x);
  EXPECT_LE(found.min.y, low.y);
  EXPECT_GE(found.max.x, high.x);
  EXPECT_GE(found.max.y, high.y);
  EXPECT_GE(found.min.x, low.x - 4);
  EXPECT_LE(found.max.y, high.y + 4);
  // The eye inside the box, and the box behind the eye.
  Camera within = camera;
  within.eye = {1, 0.5, 0.5};
  within.near_depth = 0.01;
  EXPECT_EQ(pixels_of(within, kSize, {}, box), (PixelBox{{0, 0}, {64, 48}}));
  within.eye = {1, 30, 0.5};
  within.target = {1, 31, 0.5};
  EXPECT_TRUE(pixels_of(within, kSize, {}, box).empty());
}

TEST(Camera, ParsesViewAngles) {
  EXPECT_EQ(parse_view_angles("30,-15").value(), (ViewAngles{30, -15, std::nullopt}));
  EXPECT_EQ(parse_view_angles("-720.5,90,1e3").value(), (ViewAngles{-720.5, 90, 1000}));
  for (const char* wrong :
       {"", "30", "30,", "30,15,", "30,91", "30,15,0", "30,15,-1", "30,15,2,3", "a,b", "nan,0", "1, 2"}) {
    const auto angles = parse_view_angles(wrong);
    ASSERT_FALSE(angles) << wrong;
    EXPECT_EQ(angles.error().code, ErrorCode::usage);
  }
}

TEST(Camera, RefusesInvalidCameras) {
  const auto refused = [](auto change) {
    Camera camera;
    EXPECT_TRUE(camera.check());
    change(camera);
    const auto checked = camera.check();
    return !checked && checked.error().code == ErrorCode::usage;
  };
  EXPECT_TRUE(refused([](Camera& c) { c.target = c.eye; }));
  EXPECT_TRUE(refused([](Camera& c) { c.up = c.target - c.eye; }));
  EXPECT_TRUE(refused([](Camera& c) { c.up = glm::dvec3(0); }));
  EXPECT_TRUE(refused([](Camera& c) { c.eye.x = test::kNaN; }));
  EXPECT_TRUE(refused([](Camera& c) { c.fovy = 0; }));
  EXPECT_TRUE(refused([](Camera& c) { c.fovy = std::numbers::pi; }));
  EXPECT_TRUE(refused([](Camera& c) { c.near_depth = 0; }));
  EXPECT_TRUE(refused([](Camera& c) { c.far_depth = c.near_depth; }));
}

}  // namespace
}  // namespace isoextract::render
