// Shared by the tests of the renderers: simple scenes, and rays computed without the renderer's code.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_inverse.hpp>

#include "render/renderer.hpp"
#include "support/fields.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::test {

inline render::Rendered draw(const render::Scene& scene, const render::Camera& camera,
                             const render::RenderOptions& options, const Context& context = Context()) {
  auto rendered = render::make_cpu_renderer()->draw(scene, camera, options, context);
  EXPECT_TRUE(rendered) << (rendered ? "" : rendered.error().message);
  return rendered ? std::move(*rendered) : render::Rendered();
}

// Returns a rectangle in the plane y = `y`.
inline mesh::Mesh rectangle(double y, double x0, double x1, double z0, double z1) {
  const auto at = [&](double x, double z) { return glm::vec3(glm::dvec3(x, y, z)); };
  return make_mesh("rectangle", {at(x0, z0), at(x1, z0), at(x1, z1), at(x0, z1)}, {{0, 1, 2}, {0, 2, 3}});
}

// Returns a transfer function with one color and opacity for all values.
inline render::TransferFunction constant_transfer(const glm::dvec3& color, double opacity) {
  const std::array points{render::ControlPoint{0, color, opacity}, render::ControlPoint{2, color, opacity}};
  return render::TransferFunction::create(points).value();
}

// Returns a transfer function with opacity 0 up to the value `clear`, rising above it.
inline render::TransferFunction rising_transfer(double clear, double opacity) {
  const std::array points{render::ControlPoint{0, {0.1, 0.2, 0.9}, 0}, render::ControlPoint{clear, {0.1, 0.2, 0.9}, 0},
                          render::ControlPoint{1, {1, 0.5, 0.1}, opacity}};
  return render::TransferFunction::create(points).value();
}

// Returns only ambient light, so surfaces have their own color in every direction.
inline render::ShadingModel unlit() { return {1, 0, 0, 1}; }

// The ray eye + depth * along through the center of a pixel, from the inverse clip matrix. Depth is along the view
// axis.
struct WorldRay {
  glm::dvec3 eye;
  glm::dvec3 along;
};
inline WorldRay ray_of(const render::Camera& camera, const render::PictureSize& size, int x, int y) {
  const glm::dmat4 back = glm::inverse(camera.clip_from_world(size));
  const glm::dvec4 far(2 * (x + 0.5) / size.width - 1, 1 - 2 * (y + 0.5) / size.height, 0.5, 1);
  const glm::dvec4 at = back * far;
  const glm::dvec3 way = glm::dvec3(at) / at.w - camera.eye;
  return {camera.eye, way / glm::dot(way, glm::normalize(camera.target - camera.eye))};
}

inline std::size_t pixel_of(const render::Picture& picture, int x, int y) {
  return static_cast<std::size_t>(x) + static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(y);
}

template <class T>
bool same_bytes(const Buffer<T>& a, const Buffer<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}
inline bool same_picture(const render::Picture& a, const render::Picture& b) {
  return same_bytes(a.color, b.color) && same_bytes(a.depth, b.depth) && same_bytes(a.normals, b.normals);
}

inline float largest_difference(const render::Picture& a, const render::Picture& b) {
  float largest = a.pixels() == b.pixels() ? 0 : std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < a.pixels() && i < b.pixels(); ++i) {
    for (int c = 0; c < 4; ++c) {
      const float difference = std::abs(a.color[i][c] - b.color[i][c]);
      if (!(difference <= largest)) largest = difference;
    }
  }
  return largest;
}

// Returns a ball of density 1 in the center, with a soft rim; density 0 elsewhere.
inline field::ScalarField ball(int side) {
  const double middle = (side - 1) / 2.0;
  return dense_field<float>(glm::ivec3(side), [&](int i, int j, int k) {
    const double r = glm::length(glm::dvec3(i, j, k) - middle) / middle;
    return std::clamp((0.7 - r) * 5, 0.0, 1.0);
  });
}

}  // namespace isoextract::test
