#include "render/camera.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "base/finite.hpp"

namespace isoextract::render {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Enlarges the sphere around the box so that its rim is not cut off.
constexpr double kMargin = 1.02;
// The near plane is at least this fraction of the distance away.
constexpr double kNearest = 1e-3;

double aspect_of(const PictureSize& size) { return double(size.width) / double(size.height); }

// Returns the directions up, azimuth 0 (front) and azimuth 90 (side = up x front).
std::array<glm::dvec3, 3> axes_of(UpAxis up) {
  switch (up) {
    case UpAxis::x: return {glm::dvec3(1, 0, 0), {0, 0, 1}, {0, -1, 0}};
    case UpAxis::y: return {glm::dvec3(0, 1, 0), {0, 0, 1}, {1, 0, 0}};
    case UpAxis::z: break;
  }
  return {glm::dvec3(0, 0, 1), {0, -1, 0}, {1, 0, 0}};
}

std::array<glm::dvec3, 8> corners_of(const field::Box& box) {
  std::array<glm::dvec3, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = {(i & 1) != 0 ? box.max.x : box.min.x, (i & 2) != 0 ? box.max.y : box.min.y,
                  (i & 4) != 0 ? box.max.z : box.min.z};
  }
  return corners;
}

// Moves the camera `far`, which frame_box() made for the box and angles, so near that the points just fit into the
// picture, with a margin. Returns `far` unchanged if the angles have a distance or the box is a point.
Camera closer(const Camera& far, const field::Box& box, ViewAngles angles, UpAxis up, const PictureSize& size,
              std::span<const glm::dvec3> points) {
  constexpr double kFilled = 0.9;
  if (angles.distance || box.min == box.max) return far;
  const double high = kFilled * std::tan(far.fovy / 2);
  const double wide = high * aspect_of(size);
  double distance = 1e-3 * glm::length(box.max - box.min);  // if all of the box is behind the target
  for (const glm::dvec3& point : points) {
    const glm::dvec3 seen = far.rotation() * (point - far.target);
    distance = std::max(distance, seen.z + std::max(std::abs(seen.x) / wide, std::abs(seen.y) / high));
  }
  angles.distance = distance;
  return frame_box(box, angles, up, size, far.fovy);
}

}  // namespace

Result<void> Camera::check() const {
  const auto refuse = [](const std::string& what) { return fail(ErrorCode::usage, "the camera: " + what); };
  if (!is_finite(eye) || !is_finite(target) || !is_finite(up)) return refuse("eye, target and up must be finite");
  if (!(unit() > 0) || !std::isfinite(unit())) return refuse("the eye and the target must be different points");
  const glm::dvec3 axis = (target - eye) / unit();
  const double up_length = glm::length(up);
  if (!(up_length > 0) || !std::isfinite(up_length) || glm::length(glm::cross(axis, up / up_length)) < 1e-9) {
    return refuse("the up direction must not be zero or parallel to the view direction");
  }
  if (!(fovy > 0 && fovy < std::numbers::pi)) {
    return refuse(fmt::format("expected a field of view between 0 and 180 degrees, found {:g}", fovy / kDegree));
  }
  if (!(near_depth > 0 && near_depth < far_depth && std::isfinite(far_depth))) {
    return refuse(fmt::format("expected 0 < near < far, found {:g} and {:g}", near_depth, far_depth));
  }
  return {};
}

glm::dmat3 Camera::rotation() const {
  const glm::dvec3 forward = (target - eye) / unit();
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::normalize(up)));
  return glm::transpose(glm::dmat3(right, glm::cross(right, forward), -forward));
}

field::Affine Camera::view_from_world() const {
  const glm::dmat3 turned = rotation() / unit();
  return {turned, -(turned * eye)};
}

field::Affine Camera::world_from_view() const { return {glm::transpose(rotation()) * unit(), eye}; }

glm::dmat4 Camera::clip_from_view(const PictureSize& size) const {
  return glm::perspective(fovy, aspect_of(size), near_depth / unit(), far_depth / unit());
}

glm::dmat4 Camera::clip_from_world(const PictureSize& size) const {
  const field::Affine view = view_from_world();
  glm::dmat4 placed(view.linear);
  placed[3] = glm::dvec4(view.offset, 1);
  return clip_from_view(size) * placed;
}

glm::dvec3 direction_through(const Camera& camera, const PictureSize& size, double x, double y) {
  const double half = std::tan(camera.fovy / 2);
  return {(2 * x / size.width - 1) * half * aspect_of(size), (1 - 2 * y / size.height) * half, -1};
}

PixelBox pixels_of(const Camera& camera, const PictureSize& size, const field::Affine& map, const field::Box& box) {
  const glm::dvec2 whole(size.width, size.height);
  const double half = std::tan(camera.fovy / 2);
  const glm::dvec2 scale = whole / (2 * half * glm::dvec2(aspect_of(size), 1));
  const field::Affine view = camera.view_from_world().after(map);
  const double nearest = camera.near_depth / camera.unit();
  glm::dvec2 low(std::numeric_limits<double>::infinity());
  glm::dvec2 high = -low;
  int behind = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p = view({(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                               (corner & 4) != 0 ? box.max.z : box.min.z});
    if (!(-p.z >= nearest)) {
      ++behind;
      continue;
    }
    const glm::dvec2 at = whole / 2.0 + scale * glm::dvec2(p.x, -p.y) / -p.z;
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  if (behind == 8) return {};
  if (behind > 0) return {{0, 0}, {size.width, size.height}};
  // Pixels whose centers are within the bounds, and one more on each side for rounding.
  const auto clamped = [&](const glm::dvec2& p) { return glm::ivec2(glm::clamp(p, glm::dvec2(0), whole)); };
  const PixelBox found{clamped(glm::floor(low - 1.5)), clamped(glm::ceil(high + 1.5))};
  return found.empty() ? PixelBox{} : found;
}

Result<ViewAngles> parse_view_angles(std::string_view words) {
  const auto refuse = [&] {
    return fail(ErrorCode::usage,
                fmt::format("expected azimuth and elevation in degrees, and optionally a distance above 0: "
                            "AZ,EL[,DISTANCE] with EL from -90 to 90, found '{}'",
                            words));
  };
  std::vector<double> numbers;
  for (std::string_view rest = words;;) {
    const std::size_t comma = rest.find(',');
    const std::string_view word = rest.substr(0, comma);
    double number = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (problem != std::errc() || end != word.data() + word.size() || !std::isfinite(number)) return refuse();
    numbers.push_back(number);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (numbers.size() < 2 || numbers.size() > 3 || std::abs(numbers[1]) > 90) return refuse();
  ViewAngles angles{numbers[0], numbers[1], std::nullopt};
  if (numbers.size() == 3) {
    if (!(numbers[2] > 0)) return refuse();
    angles.distance = numbers[2];
  }
  return angles;
}

Camera frame_box(const field::Box& box, const ViewAngles& angles, UpAxis up, const PictureSize& size, double fovy) {
  const auto [upwards, front, side] = axes_of(up);
  const double azimuth = (angles.azimuth + angles.front) * kDegree;
  const double elevation = angles.elevation * kDegree;
  const glm::dvec3 around = std::cos(azimuth) * front + std::sin(azimuth) * side;
  const glm::dvec3 away = std::cos(elevation) * around + std::sin(elevation) * upwards;

  const glm::dvec3 middle = angles.look_at.value_or(box.min + (box.max - box.min) / 2.0);
  const double radius = glm::length(glm::max(glm::abs(box.max - middle), glm::abs(box.min - middle)));
  const double across = 2 * std::atan(std::tan(fovy / 2) * std::min(1.0, aspect_of(size)));
  const double fitting = radius > 0 ? kMargin * radius / std::sin(across / 2) : 1;

  Camera camera;
  camera.target = middle;
  // Far from the world's origin, adding this distance may be lost to rounding; check() then fails.
  const double distance = angles.distance.value_or(fitting);
  camera.eye = middle + distance * away;
  // Seen straight from above or below, the up axis is parallel to the view, so `around` defines up in the picture.
  // Elsewhere the result equals that of the up axis.
  camera.up = std::cos(elevation) * upwards - std::sin(elevation) * around;
  camera.fovy = fovy;
  const double seen = radius > 0 ? kMargin * radius : distance / 2;
  camera.far_depth = distance + seen;
  camera.near_depth = std::max(distance - seen, kNearest * distance);
  return camera;
}

void enclose_box(Camera& camera, const field::Box& box) {
  const double radius =
      kMargin * glm::length(glm::max(glm::abs(box.max - camera.target), glm::abs(box.min - camera.target)));
  camera.far_depth = std::max(camera.far_depth, camera.unit() + radius);
  camera.near_depth = std::min(camera.near_depth, std::max(camera.unit() - radius, kNearest * camera.unit()));
}

Camera frame_box_closely(const field::Box& box, const ViewAngles& angles, UpAxis up, const PictureSize& size,
                         double fovy) {
  return closer(frame_box(box, angles, up, size, fovy), box, angles, up, size, corners_of(box));
}

Camera frame_turn(const field::Box& box, const ViewAngles& angles, UpAxis up, const PictureSize& size, double fovy) {
  constexpr int kTurns = 32;
  const Camera far = frame_box(box, angles, up, size, fovy);
  const auto [upwards, front, side] = axes_of(up);
  std::vector<glm::dvec3> seen;
  for (const glm::dvec3& corner : corners_of(box)) {
    const glm::dvec3 from_target = corner - far.target;
    const double height = glm::dot(from_target, upwards);
    const double radius = glm::length(from_target - height * upwards);
    for (int turn = 0; turn < kTurns; ++turn) {
      // Turns start at the camera's azimuth, so that the distance is the same for all pictures of the turntable.
      const double angle = (angles.azimuth + angles.front + 360.0 / kTurns * turn) * kDegree;
      seen.push_back(far.target + height * upwards + radius * (std::cos(angle) * front + std::sin(angle) * side));
    }
  }
  const Camera near = closer(far, box, angles, up, size, seen);
  return near.unit() < far.unit() ? near : far;
}

}  // namespace isoextract::render
