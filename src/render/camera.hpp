// A perspective camera in the world, in double, and where its pixels look.
//
// View space has the eye at 0 and the axes of OpenGL: x to the right, y up, z backwards. Depth is the distance along
// the view axis, -z. A point of the view of pixel (x, y) at depth d is d * direction(x, y), so that depth is the
// parameter along every ray; the way between two depths is length(direction) times as long.
//
// Scenes may be of any size: view coordinates are divided by `unit()`, the distance from eye to target, wherever a
// renderer computes with them (view_of(), clip_of_view(), direction()); depths of pictures are in world units again.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "base/words.hpp"
#include "field/affine.hpp"

namespace isoextract::render {

struct PictureSize {
  static constexpr int kMaxSide = 16384;

  int width = 0;
  int height = 0;

  friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

struct Camera {
  static constexpr double kDefaultFovy = 0.785;  // radians, as in the paper on moving water as voxels (docs/papers.md)

  glm::dvec3 eye{0.0, -1.0, 0.0};
  glm::dvec3 target{0.0};
  glm::dvec3 up{0.0, 0.0, 1.0};  // not along the view axis; need not be perpendicular to it
  double fovy = kDefaultFovy;    // vertical field of view, radians, in (0, pi)
  double near_depth = 0.01;      // in world units; what is nearer is not drawn
  double far_depth = 100;        // what is farther is not drawn

  // Finite, eye and target apart, up not along the axis, 0 < near < far, fovy in range. ErrorCode::usage tells which
  // not.
  [[nodiscard]] Result<void> check() const;

  // World units that one unit of view space stands for.
  [[nodiscard]] double unit() const { return glm::length(target - eye); }

  // Rows: right, up and backwards, unit vectors of the world. direction in view space = rotation() * that of the world.
  [[nodiscard]] glm::dmat3 rotation() const;
  // World -> view space in units of unit(). For meshes far away: apply it to their origin in double, and
  // rotation() / unit() to their float positions.
  [[nodiscard]] field::Affine view_of_world() const;
  [[nodiscard]] field::Affine world_of_view() const;
  // View space in units -> clip space of OpenGL (z / w from -1 at near to 1 at far). w is the depth in units.
  [[nodiscard]] glm::dmat4 clip_of_view(const PictureSize& size) const;
  // Clip space of the whole way from the world, as glm::perspective and glm::lookAt give it together.
  [[nodiscard]] glm::dmat4 clip_of_world(const PictureSize& size) const;
};

// The direction in view space of the view through position (x, y) of the picture, in pixels from the upper left corner,
// z always -1: pixel (0, 0), the upper left one, looks through (0.5, 0.5).
[[nodiscard]] glm::dvec3 direction_through(const Camera& camera, const PictureSize& size, double x, double y);

// Pixels [min, max) of a picture.
struct PixelBox {
  glm::ivec2 min{0};
  glm::ivec2 max{0};

  [[nodiscard]] bool empty() const { return max.x <= min.x || max.y <= min.y; }
  friend bool operator==(const PixelBox&, const PixelBox&) = default;
};

// The pixels whose views may meet the image of `box` by `map`, from its 8 corners (docs/papers.md, hybrid ray casting,
// equation 2): all of the picture where a corner is not in front of the near plane but another one is, none where all
// are behind it.
[[nodiscard]] PixelBox pixels_of(const Camera& camera, const PictureSize& size, const field::Affine& map,
                                 const field::Box& box);

// Where to look from: azimuth around the up axis and elevation above the plane across it, in degrees, and perhaps the
// distance from the target in world units.
struct ViewAngles {
  double azimuth = 35;
  double elevation = 20;                // from -90 to 90
  std::optional<double> distance{};     // nothing: so far that all of the box is seen
  std::optional<glm::dvec3> look_at{};  // the target, in the world; nothing: the middle of the box

  // Whether the camera is the same for every box.
  [[nodiscard]] bool is_fixed() const { return distance && look_at; }

  friend bool operator==(const ViewAngles&, const ViewAngles&) = default;
};

// "AZ,EL[,DISTANCE]". ErrorCode::usage, with what was expected, for anything else.
[[nodiscard]] Result<ViewAngles> parse_view_angles(std::string_view words);

enum class UpAxis { x, y, z };
constexpr auto words_of(UpAxis /*type*/) {
  return std::array{Word{UpAxis::x, "x"}, Word{UpAxis::y, "y"}, Word{UpAxis::z, "z"}};
}

// A camera that looks at `angles.look_at`, or else at the middle of `box`. Azimuth 0 is in front: at -y where z is up,
// at +z where x or y is; it grows counter-clockwise as seen from above, so that 90 is at +x where y or z is up and at
// -y where x is. Without a distance the sphere around the box, with the target as its middle, fits into the narrower
// side of the picture. Near and far contain that sphere wherever it is in front of the eye. A box of one point is
// looked at from a distance of 1.
[[nodiscard]] Camera framing(const field::Box& box, const ViewAngles& angles, UpAxis up, const PictureSize& size,
                             double fovy = Camera::kDefaultFovy);

}  // namespace isoextract::render
