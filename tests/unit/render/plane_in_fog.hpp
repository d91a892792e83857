// A box of uniform density and a plane: every way in which a ray can hit them, and the closed form of the result.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>

#include "unit/render/drawing.hpp"

namespace isoextract::render {

inline constexpr double kAllowed = 2.0 / 255;
inline constexpr double kSigma = 0.21;
inline const glm::dvec3 kFog(0.2, 0.5, 0.9);
inline const glm::dvec3 kPaint(0.9, 0.3, 0.1);
inline const glm::dvec4 kBehind(0.05, 0.15, 0.1, 1);

// The six cases of hybrid ray casting.
enum class Case { neither, surface_only, volume_only, surface_in_front, volume_in_front, inside };

struct Expected {
  glm::dvec4 color;
  Case met;
};

class PlaneInFog {
 public:
  PlaneInFog(double plane, double opacity, bool with_volume = true)
      : field_(test::dense_field<float>(glm::ivec3(9), [](int, int, int) { return 1; })),
        // Covers half of the box, and the space beside it.
        rectangle_(test::rectangle(plane, 4.13, 13, -3.5, 7.2)),
        plane_(plane),
        opacity_(opacity) {
    volume_ = {&field_, field_.index_to_world, test::constant_transfer(kFog, 1 - std::exp(-kSigma)), 1};
    if (with_volume) scene_.volume = &volume_;
    scene_.surfaces.push_back({&rectangle_, kPaint, opacity});
    scene_.shading = test::unlit();
    scene_.background = kBehind;
    camera_ = frame_box({{-4, -4, -4}, {12, 12, 12}}, {20, 15}, UpAxis::z, size());
  }
  static PictureSize size() { return {60, 44}; }
  const Scene& scene() const { return scene_; }
  const Camera& camera() const { return camera_; }

  Expected expected(int x, int y) const {
    const test::WorldRay ray = test::ray_of(camera_, size(), x, y);
    double enter = camera_.near_depth;
    double leave = camera_.far_depth;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (0 - ray.eye[axis]) / ray.along[axis];
      const double b = (8 - ray.eye[axis]) / ray.along[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    const bool in_volume = scene_.volume != nullptr && enter < leave;
    const double at = (plane_ - ray.eye.y) / ray.along.y;
    const glm::dvec3 p = ray.eye + at * ray.along;
    const bool on_plane = at > 0 && p.x > 4.13 && p.x < 13 && p.z > -3.5 && p.z < 7.2;

    glm::dvec3 light(0);
    double left = 1;
    const auto fog = [&](double from, double to) {
      const double opacity = 1 - std::exp(-kSigma * (to - from) * glm::length(ray.along));
      light += left * opacity * kFog;
      left *= 1 - opacity;
    };
    const auto paint = [&] {
      light += left * opacity_ * kPaint;
      left *= 1 - opacity_;
    };
    Case met = Case::neither;
    if (!in_volume && on_plane) {
      met = Case::surface_only;
      paint();
    } else if (in_volume && !on_plane) {
      met = Case::volume_only;
      fog(enter, leave);
    } else if (in_volume && on_plane) {
      met = at <= enter ? Case::surface_in_front : at >= leave ? Case::volume_in_front : Case::inside;
      if (at <= enter) paint();
      fog(enter, std::clamp(at, enter, leave));
      if (at > enter && at < leave) paint();
      fog(std::clamp(at, enter, leave), leave);
      if (at >= leave) paint();
    }
    light += left * glm::dvec3(kBehind);
    return {glm::dvec4(light, 1), met};
  }

 private:
  field::ScalarField field_;
  mesh::Mesh rectangle_;
  double plane_;
  double opacity_;
  Volume volume_;
  Scene scene_;
  Camera camera_;
};

// Returns the largest difference of a channel from the closed form, and counts the cases.
inline double difference(const PlaneInFog& setup, const Picture& picture, std::map<Case, int>& met) {
  double largest = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const Expected expected = setup.expected(x, y);
      ++met[expected.met];
      const glm::dvec4 off = glm::abs(glm::dvec4(picture.color[test::pixel_of(picture, x, y)]) - expected.color);
      largest = std::max({largest, off.r, off.g, off.b, off.a});
    }
  }
  return largest;
}

// Checks that `draw` matches the closed form: within `allowed` without early termination, within kAllowed with it.
// Checks that all six cases occur.
template <class Draw>
void expect_six_cases(const Draw& draw, double allowed) {
  std::map<Case, int> met;
  for (const double plane : {-2.9, 3.37, 10.6}) {
    for (const double opacity : {1.0, 0.4}) {
      const PlaneInFog setup(plane, opacity);
      RenderOptions options{PlaneInFog::size()};
      options.early_termination = false;
      const double exact = difference(setup, draw(setup.scene(), setup.camera(), options).picture, met);
      EXPECT_LT(exact, allowed) << plane << " " << opacity;
      options.early_termination = true;
      const double ended = difference(setup, draw(setup.scene(), setup.camera(), options).picture, met);
      EXPECT_LE(ended, kAllowed) << plane << " " << opacity;
    }
  }
  for (const Case one : {Case::neither, Case::surface_only, Case::volume_only, Case::surface_in_front,
                         Case::volume_in_front, Case::inside}) {
    EXPECT_GT(met[one], 100) << static_cast<int>(one);
  }
}

}  // namespace isoextract::render
