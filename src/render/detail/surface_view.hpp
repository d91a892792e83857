// The surfaces of a scene as a camera sees them: corners in view space, and the light that comes from a triangle.
//
// View space is in units of Camera::unit(). Triangles of all surfaces are numbered in one row, surface after surface.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "render/camera.hpp"
#include "render/scene.hpp"

namespace isoextract::render::detail {

using Corners = std::array<glm::dvec3, 3>;

// Light from a place on a surface.
struct Shade {
  glm::vec3 colour;  // straight
  float opacity;
  glm::vec3 normal;  // in the world, towards the eye
};

// Linear, with alpha; of vertices, as Surface::vertex_colours tells.
[[nodiscard]] glm::dvec4 vertex_colour(const mesh::Attribute& attribute, std::size_t vertex);

class SurfaceView {
 public:
  // Scene and camera are sound, and outlive this.
  SurfaceView(const Scene& scene, const Camera& camera, const PictureSize& size);

  [[nodiscard]] std::uint64_t triangles() const { return first_.back(); }
  [[nodiscard]] std::size_t surface_of(std::uint64_t triangle) const;
  [[nodiscard]] Corners corners(std::uint64_t triangle) const { return corners(surface_of(triangle), triangle); }
  [[nodiscard]] Corners corners(std::size_t surface, std::uint64_t triangle) const;
  // Whether all that it covers is hidden.
  [[nodiscard]] bool hides(std::size_t surface) const { return looks_[surface].hides; }
  [[nodiscard]] bool is_smooth(std::size_t surface) const { return looks_[surface].smooth; }
  // Of its vertices, or null: then it has one of its own.
  [[nodiscard]] const mesh::Attribute* colours(std::size_t surface) const { return looks_[surface].colours; }
  // Of stored positions.
  [[nodiscard]] const field::Affine& view(std::size_t surface) const { return looks_[surface].view; }
  // Of directions of the world.
  [[nodiscard]] const glm::dmat3& rotation() const { return rotation_; }
  // A light, as a unit vector in view space.
  [[nodiscard]] const glm::dvec3& towards(std::size_t light) const { return towards_[light]; }

  // The view through the picture's upper left corner, and what a pixel changes of it to the right and downwards.
  [[nodiscard]] glm::dvec2 to_corner() const { return {to_left_, to_top_}; }
  [[nodiscard]] const glm::dvec2& per_pixel() const { return per_pixel_; }
  // As direction_through().
  [[nodiscard]] glm::dvec3 direction(double x, double y) const {
    return {to_left_ + per_pixel_.x * x, to_top_ - per_pixel_.y * y, -1};
  }
  // Where a point in front of the eye is, in pixels from the upper left corner.
  [[nodiscard]] glm::dvec2 pixel_of(const glm::dvec3& p) const {
    return {(p.x / -p.z - to_left_) / per_pixel_.x, (to_top_ - p.y / -p.z) / per_pixel_.y};
  }

  // Where the ray of `direction` meets the triangle's plane.
  [[nodiscard]] Shade shade(std::uint64_t triangle, const glm::dvec3& direction) const;

 private:
  struct Look {
    field::Affine view;                        // of stored positions
    const mesh::Attribute* colours = nullptr;  // of vertices
    bool smooth = false;
    bool hides = true;
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
