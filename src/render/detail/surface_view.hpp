// The surfaces of a scene as a camera sees them: triangle corners in view space, and shading.
//
// View space is in units of Camera::unit(). Triangles are numbered consecutively across all surfaces.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "render/camera.hpp"
#include "render/scene.hpp"

namespace isoextract::render::detail {

using Corners = std::array<glm::dvec3, 3>;

// The result of shading a point of a surface.
struct Shade {
  glm::vec3 color;  // straight alpha
  float opacity;
  glm::vec3 normal;  // in the world, towards the eye
};

class SurfaceView {
 public:
  // `scene` and `camera` have passed check(). `scene` must outlive this object.
  SurfaceView(const Scene& scene, const Camera& camera, const PictureSize& size);

  [[nodiscard]] std::uint64_t triangles() const { return first_.back(); }
  [[nodiscard]] std::size_t surface_of(std::uint64_t triangle) const;
  [[nodiscard]] Corners corners(std::uint64_t triangle) const { return corners(surface_of(triangle), triangle); }
  [[nodiscard]] Corners corners(std::size_t surface, std::uint64_t triangle) const;
  // Returns whether the surface is opaque everywhere.
  [[nodiscard]] bool is_opaque(std::size_t surface) const { return looks_[surface].is_opaque; }
  [[nodiscard]] bool is_smooth(std::size_t surface) const { return looks_[surface].smooth; }
  // Returns the vertex colors, or null if the surface has one color.
  [[nodiscard]] const mesh::Attribute* colors(std::size_t surface) const { return looks_[surface].colors; }
  // Returns the map from stored positions to view space.
  [[nodiscard]] const field::Affine& view(std::size_t surface) const { return looks_[surface].view; }
  // Returns the map from world directions to view space.
  [[nodiscard]] const glm::dmat3& rotation() const { return rotation_; }
  // Returns the unit vector to a light, in view space.
  [[nodiscard]] const glm::dvec3& towards(std::size_t light) const { return towards_[light]; }

  // Returns the direction through the picture's upper left corner (x and y at z = -1). Per pixel, x grows by
  // per_pixel().x to the right, and y falls by per_pixel().y downwards.
  [[nodiscard]] glm::dvec2 to_corner() const { return {to_left_, to_top_}; }
  [[nodiscard]] const glm::dvec2& per_pixel() const { return per_pixel_; }
  // Returns the same as direction_through().
  [[nodiscard]] glm::dvec3 direction(double x, double y) const {
    return {to_left_ + per_pixel_.x * x, to_top_ - per_pixel_.y * y, -1};
  }
  // Returns the picture position of a point in front of the eye, in pixels from the upper left corner.
  [[nodiscard]] glm::dvec2 pixel_of(const glm::dvec3& p) const {
    return {(p.x / -p.z - to_left_) / per_pixel_.x, (to_top_ - p.y / -p.z) / per_pixel_.y};
  }

  // Shades the point where the ray of `direction` hits the triangle's plane.
  [[nodiscard]] Shade shade(std::uint64_t triangle, const glm::dvec3& direction) const;

 private:
  struct Look {
    field::Affine view;                       // from stored positions
    const mesh::Attribute* colors = nullptr;  // vertex colors, or null
    bool smooth = false;
    bool is_opaque = true;
  };

  const Scene& scene_;
  glm::dmat3 rotation_;
  double to_left_;
  double to_top_;
  glm::dvec2 per_pixel_;
  std::vector<std::uint64_t> first_;  // each surface's first triangle, and the end
  std::vector<Look> looks_;
  std::vector<glm::dvec3> towards_;  // the lights, unit vectors in view space
};

}  // namespace isoextract::render::detail
