// A perspective camera in world space, in double, and the view directions of its pixels.
//
// View space has the eye at 0 and the axes of OpenGL: x to the right, y up, z backwards. Depth is the distance along
// the view axis, -z. The ray through picture position (x, y) reaches the point d * direction_through(x, y) at depth d.
// The length of a ray between two depths is the difference of the depths times the length of direction_through().
//
// Scenes may have any size, so renderers compute in view coordinates divided by unit(), the distance from eye to target
// (view_from_world(), clip_from_view()). direction_through() is the same in both. Depths of pictures are in world
// units.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include <glm/glm.hpp>

#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "field/affine.hpp"

namespace isoextract::render {

struct PictureSize {
  static constexpr int kMaxSide = 16384;

  int width = 0;
  int height = 0;

  friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

struct Camera {
  static constexpr double kDefaultFovy = 0.785;  // radians; from the paper on moving water as voxels (docs/papers.md)

  glm::dvec3 eye{0.0, -1.0, 0.0};
  glm::dvec3 target{0.0};
  glm::dvec3 up{0.0, 0.0, 1.0};  // not parallel to the view axis; need not be perpendicular to it
  double fovy = kDefaultFovy;    // vertical field of view, radians, in (0, pi)
  double near_depth = 0.01;      // in world units; nearer objects are not drawn
  double far_depth = 100;        // in world units; farther objects are not drawn

  // Checks that values are finite, eye and target differ, up is neither 0 nor parallel to the view axis, 0 < near <
  // far, and fovy is in range. Otherwise fails with ErrorCode::usage and names the reason.
  [[nodiscard]] Result<void> check() const;

  // Returns the distance from eye to target. Renderers divide view coordinates by it.
  [[nodiscard]] double unit() const { return glm::length(target - eye); }

  // Returns the rotation from world to view space. Its rows are the unit vectors right, up and backwards in the world.
  [[nodiscard]] glm::dmat3 rotation() const;
  // Returns the map from world space to view coordinates divided by unit(). For a mesh far from the world's origin,
  // apply it to mesh.origin in double, and rotation() / unit() to the float positions.
  [[nodiscard]] field::Affine view_from_world() const;
  [[nodiscard]] field::Affine world_from_view() const;
  // Returns the map from view coordinates divided by unit() to OpenGL's clip space (z / w is -1 at near and 1 at far; w
  // is depth / unit()).
  [[nodiscard]] glm::dmat4 clip_from_view(const PictureSize& size) const;
  // Returns the map from world to clip space: the product of glm::perspective and glm::lookAt divided by unit(), so
  // that w is depth / unit().
  [[nodiscard]] glm::dmat4 clip_from_world(const PictureSize& size) const;
};

// Returns the direction in view space through picture position (x, y), with z = -1. Positions are in pixels from the
// upper left corner; the center of pixel (0, 0) is (0.5, 0.5).
[[nodiscard]] glm::dvec3 direction_through(const Camera& camera, const PictureSize& size, double x, double y);

// The pixels [min, max) of a picture.
struct PixelBox {
  glm::ivec2 min{0};
  glm::ivec2 max{0};

  [[nodiscard]] bool empty() const { return max.x <= min.x || max.y <= min.y; }
  friend bool operator==(const PixelBox&, const PixelBox&) = default;
};

// Projects the 8 corners of `box`, which `map` maps to the world, and returns the rectangle of the pixels that may see
// the box (docs/papers.md, hybrid ray casting, equation 2). Returns the whole picture if some corners are nearer than
// the near plane, and an empty rectangle if all are.
[[nodiscard]] PixelBox pixels_of(const Camera& camera, const PictureSize& size, const field::Affine& map,
                                 const field::Box& box);

// The view direction in degrees: azimuth around the up axis and elevation above the plane perpendicular to it. Distance
// and target, in world units, are optional.
struct ViewAngles {
  double azimuth = 35;
  double elevation = 20;                // from -90 to 90
  std::optional<double> distance{};     // if unset, far enough to see the whole box
  std::optional<glm::dvec3> look_at{};  // the target in the world; if unset, the center of the box
  double front = 0;                     // azimuth of the front of the scene, in degrees; added to `azimuth`

  // Returns whether distance and target are set, so that the camera does not depend on the box.
  [[nodiscard]] bool is_fixed() const { return distance && look_at; }

  friend bool operator==(const ViewAngles&, const ViewAngles&) = default;
};

// Parses "AZ,EL[,DISTANCE]". Fails with ErrorCode::usage.
[[nodiscard]] Result<ViewAngles> parse_view_angles(std::string_view words);

enum class UpAxis { x, y, z };
constexpr auto words_of(UpAxis /*type*/) {
  return std::array{Word{UpAxis::x, "x"}, Word{UpAxis::y, "y"}, Word{UpAxis::z, "z"}};
}

// Returns a camera that looks at `angles.look_at` or, if unset, at the center of `box`.
// Azimuth 0 looks from the front: from -y if z is up, from +z if x or y is up (turned by ViewAngles::front). It grows
// counter-clockwise as seen from above: azimuth 90 is at +x if y or z is up, and at -y if x is up. Without a distance,
// the sphere around the target that contains the box fits into the narrower side of the picture. If the sphere is a
// point, the distance is 1. The near and far planes enclose the part of that sphere that is at least 0.001 of the
// distance in front of the eye. If the sphere is a point, they are at 0.5 and 1.5 times the distance.
[[nodiscard]] Camera frame_box(const field::Box& box, const ViewAngles& angles, UpAxis up, const PictureSize& size,
                               double fovy = Camera::kDefaultFovy);

// Moves the near and far planes apart so that their depth range includes the range that frame_box() chooses for `box`.
void enclose_box(Camera& camera, const field::Box& box);

// Returns the camera of frame_box(). If `angles` has no distance, chooses the shortest distance at which the corners of
// the box fit into the picture, with a margin; this distance depends on the angles.
[[nodiscard]] Camera frame_box_closely(const field::Box& box, const ViewAngles& angles, UpAxis up,
                                       const PictureSize& size, double fovy = Camera::kDefaultFovy);

// Returns the camera of frame_box(). If `angles` has no distance, chooses the shortest distance at which the box fits
// into the picture while it turns around the up axis. This distance depends on the elevation, not on the azimuth, and
// never exceeds the distance of frame_box().
[[nodiscard]] Camera frame_turn(const field::Box& box, const ViewAngles& angles, UpAxis up, const PictureSize& size,
                                double fovy = Camera::kDefaultFovy);

}  // namespace isoextract::render
