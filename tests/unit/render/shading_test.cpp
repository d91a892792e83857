// Surfaces without a volume: compares shading with closed forms, and tests which pixels a triangle covers.
#include <cmath>
#include <random>

#include <tbb/global_control.h>

#include "render/surface_normals.hpp"
#include "unit/render/drawing.hpp"

namespace isoextract::render {
namespace {

Camera straight_at(const glm::dvec3& target, double distance) {
  Camera camera;
  camera.target = target;
  camera.eye = target - glm::dvec3(0, distance, 0);
  camera.near_depth = distance / 100;
  camera.far_depth = distance * 100;
  return camera;
}

// Computes the color by the formula of ShadingModel.
double blinn_of(const glm::dvec3& normal, const glm::dvec3& light, const glm::dvec3& to_eye, double base,
                const ShadingModel& model) {
  const glm::dvec3 l = glm::normalize(light);
  const double lambert = glm::dot(normal, l);
  if (lambert <= 0) return base * model.ambient;
  const double gloss = std::max(glm::dot(normal, glm::normalize(l + to_eye)), 0.0);
  return base * (model.ambient + model.diffuse * lambert) + model.specular * std::pow(gloss, model.shininess);
}

TEST(Shading, LightsRectangleByFormula) {
  const mesh::Mesh rectangle = test::rectangle(0, -3, 3, -3, 3);
  const Camera camera = straight_at({0, 0, 0}, 4);
  Scene scene;
  scene.surfaces.push_back({&rectangle, {0.5, 0.25, 1}});
  scene.lights = {{{0.3, -0.8, 0.4}, false, {1, 1, 1}}};
  const Rendered rendered = test::draw(scene, camera, {{32, 24}});
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 32; ++x) {
      const test::WorldRay ray = test::ray_of(camera, {32, 24}, x, y);
      const std::size_t i = test::pixel_of(rendered.picture, x, y);
      // With reversed winding the normal is flipped towards the eye.
      const glm::dvec3 normal(0, -1, 0);
      for (int c = 0; c < 3; ++c) {
        const double base = scene.surfaces[0].color[c];
        EXPECT_NEAR(rendered.picture.color[i][c],
                    blinn_of(normal, {0.3, -0.8, 0.4}, -glm::normalize(ray.along), base, scene.shading), 1e-6);
      }
      EXPECT_NEAR(rendered.picture.depth[i], 4, 1e-6);
    }
  }
  EXPECT_EQ(rendered.statistics.fragments, 32U * 24);
}

TEST(Shading, LightsSphereByLambert) {
  const mesh::Mesh sphere = test::sphere(60, true);
  const Camera camera = straight_at({0, 0, 0}, 5);
  constexpr PictureSize kSquare{64, 64};
  Scene scene;
  scene.surfaces.push_back({&sphere, {1, 1, 1}});
  scene.lights = {{{0.5, 0.6, 0.9}, true, {1, 1, 1}}};
  scene.shading = {0.1, 0.8, 0, 1};
  // In the world, right is x, up is z, and -y points to the viewer.
  const glm::dvec3 light(0.5, -0.9, 0.6);
  for (const Shading shading : {Shading::smooth, Shading::flat}) {
    scene.surfaces[0].shading = shading;
    const Picture picture = test::draw(scene, camera, {kSquare}).picture;
    int seen = 0;
    double sum = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const test::WorldRay ray = test::ray_of(camera, kSquare, x, y);
        const double a = glm::dot(ray.along, ray.along);
        const double b = glm::dot(ray.along, ray.eye);
        const double inside = b * b - a * (glm::dot(ray.eye, ray.eye) - 1);
        const glm::vec4 pixel = picture.color[test::pixel_of(picture, x, y)];
        if (inside < -0.5) {
          EXPECT_EQ(pixel, glm::vec4(0));
        }
        if (inside < 0.2) continue;  // skips the rim
        const double depth = (-b - std::sqrt(inside)) / a;
        const glm::dvec3 normal = ray.eye + depth * ray.along;
        const double expected = blinn_of(normal, light, -glm::normalize(ray.along), 1, scene.shading);
        EXPECT_NEAR(pixel.r, expected, shading == Shading::smooth ? 0.005 : 0.05);
        EXPECT_NEAR(picture.depth[test::pixel_of(picture, x, y)], depth, 0.01);
        sum += std::abs(pixel.r - expected);
        ++seen;
      }
    }
    EXPECT_GT(seen, 300);
    EXPECT_LT(sum / seen, shading == Shading::smooth ? 0.001 : 0.02);
  }
}

TEST(Shading, ComputesMissingVertexNormals) {
  mesh::Mesh made = test::sphere(40, false);
  ASSERT_TRUE(add_normals(made, "sphere", Context()));
  ASSERT_EQ(made.normals.size(), made.positions.size());
  for (std::size_t v = 0; v < made.positions.size(); ++v) {
    EXPECT_GT(glm::dot(made.normals[v], made.positions[v]), 0.999F);
  }
  const Context small{MemoryBudget(1000)};
  mesh::Mesh refused = test::sphere(40, false);
  const auto added = add_normals(refused, "sphere.stl", small);
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().code, ErrorCode::out_of_memory);
}

TEST(Shading, InterpolatesVertexColorsInLinearLight) {
  mesh::Mesh rectangle = test::rectangle(0, -1, 1, -1, 1);
  mesh::Attribute colors{"COLOR", mesh::AttributeRole::color, mesh::ComponentType::f32, 4,
                         false,   Buffer<std::byte>(64)};
  // Red on the left, blue and half transparent on the right.
  const std::array<glm::vec4, 4> values{glm::vec4(1, 0, 0, 1), {0, 0, 1, 0.5}, {0, 0, 1, 0.5}, {1, 0, 0, 1}};
  std::memcpy(colors.values.data(), values.data(), 64);
  rectangle.attributes.push_back(std::move(colors));
  Scene scene;
  scene.surfaces.push_back({&rectangle, {0, 1, 0}, 1, Shading::flat, true});
  scene.shading = test::unlit();
  const Camera camera = straight_at({0, 0, 0}, 10);
  const Picture picture = test::draw(scene, camera, {{40, 30}}).picture;
  int seen = 0;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      const glm::dvec3 at = 10.0 * test::ray_of(camera, {40, 30}, x, y).along;
      if (std::abs(at.x) > 0.999 || std::abs(at.z) > 0.999) continue;
      const double right = (at.x + 1) / 2;
      const double alpha = 1 - right / 2;
      const glm::vec4 pixel = picture.color[test::pixel_of(picture, x, y)];
      EXPECT_NEAR(glm::length(glm::dvec4(pixel) - glm::dvec4(alpha * (1 - right), 0, alpha * right, alpha)), 0, 1e-5);
      ++seen;
    }
  }
  EXPECT_GT(seen, 10);
}

// The vertices of the grid are at pixel centers: exactly one of the triangles that meet there covers the pixel.
TEST(Shading, CoversSharedEdgesExactlyOnce) {
  constexpr int kSide = 16;
  std::mt19937 engine(3);
  for (const double jitter : {0.0, 0.03}) {
    std::uniform_real_distribution<double> off(-jitter, jitter);
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    for (int j = 0; j <= kSide; ++j) {
      for (int i = 0; i <= kSide; ++i) {
        // At depth 1 the picture is 2 wide.
        positions.emplace_back(
            glm::dvec3((2 * i + 1.0) / kSide - 1 + off(engine), 0, (2 * j + 1.0) / kSide - 1 + off(engine)));
        if (i == kSide || j == kSide) continue;
        const auto at = static_cast<std::uint32_t>(i + (kSide + 1) * j);
        const bool flipped = (i + j) % 2 != 0;
        if (flipped) {
          triangles.insert(triangles.end(), {{at, at + 1, at + kSide + 1}, {at + 1, at + kSide + 2, at + kSide + 1}});
        } else {
          triangles.insert(triangles.end(), {{at, at + 1, at + kSide + 2}, {at + kSide + 2, at + kSide + 1, at}});
        }
      }
    }
    const mesh::Mesh grid = test::make_mesh("grid", positions, triangles);
    Scene scene;
    scene.surfaces.push_back({&grid, {1, 1, 1}, 0.5, Shading::flat});
    Camera camera = straight_at({0, 0, 0}, 1);
    camera.fovy = std::acos(0.0);
    const Picture picture = test::draw(scene, camera, {{kSide, kSide}}).picture;
    // Skips the outermost pixels, which moved vertices may leave uncovered.
    for (int y = 1; y + 1 < kSide; ++y) {
      for (int x = 1; x + 1 < kSide; ++x) {
        EXPECT_EQ(picture.color[test::pixel_of(picture, x, y)].a, 0.5F) << x << " " << y << " " << jitter;
      }
    }
  }
}

TEST(Shading, DrawsTrianglesAroundEye) {
  // A floor that continues behind the eye, and a wall behind the eye.
  const mesh::Mesh floor =
      test::make_mesh("floor", {{-50, -50, -1}, {50, -50, -1}, {0, 80, -1}, {-50, -9, -50}, {50, -9, -50}, {0, -9, 90}},
                      {{0, 1, 2}, {3, 4, 5}});
  Scene scene;
  scene.surfaces.push_back({&floor, {1, 1, 1}});
  scene.shading = test::unlit();
  const Camera camera = straight_at({0, 0, 0}, 4);
  const Picture picture = test::draw(scene, camera, {{20, 20}}).picture;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      const test::WorldRay ray = test::ray_of(camera, {20, 20}, x, y);
      const double depth = -1 / ray.along.z;
      const glm::dvec3 p = ray.eye + depth * ray.along;
      const bool on_floor = depth > 0 && std::abs(p.x) < 50 * (80 - p.y) / 130 && p.y < 80;
      EXPECT_EQ(picture.color[test::pixel_of(picture, x, y)].a, on_floor ? 1 : 0) << x << " " << y;
    }
  }
}

TEST(Shading, DrawsMeshFarFromOrigin) {
  const mesh::Mesh here = test::sphere(20, true);
  const glm::dvec3 away(1e7, -3e7, 2e7);
  const mesh::Mesh there = test::sphere(20, true, "far", away);
  Scene scene;
  scene.surfaces.push_back({&here, {0.4, 0.5, 0.6}, 0.5});
  const Picture picture = test::draw(scene, straight_at({0, 0, 0}, 5), {{40, 40}}).picture;
  scene.surfaces[0].mesh = &there;
  const Picture far = test::draw(scene, straight_at(away, 5), {{40, 40}}).picture;
  EXPECT_LT(test::largest_difference(picture, far), 1e-5);
}

}  // namespace
}  // namespace isoextract::render
