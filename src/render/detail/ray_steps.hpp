// The steps of a ray that all ray casters share: the composited pixel, and how slabs and bricks follow each other.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include <glm/glm.hpp>

#include "render/detail/slab_batch.hpp"
#include "render/detail/surface_tiles.hpp"
#include "render/detail/surface_view.hpp"
#include "render/detail/volume_bricks.hpp"
#include "render/detail/volume_samples.hpp"
#include "render/renderer.hpp"

namespace isoextract::render::detail {

// The volume relative to the camera. Depths are in units of Camera::unit().
struct VolumeView {
  const VolumeSamples* samples = nullptr;
  const VolumeBricks* bricks = nullptr;  // null: skips nothing
  field::Box box;                        // in index space
  glm::dvec3 eye{0.0};                   // in index space
  glm::dmat3 index_of_view{1.0};         // maps directions
  double unit = 1;
  double step = 1;                       // in world units
  double per_length = 1;                 // transfer function lengths per world unit
  const VolumeView* emission = nullptr;  // of Volume::emission, with the unit, step and per_length of the volume
};

struct Pixel {
  glm::vec4 color{0.0F};  // premultiplied
  float depth = std::numeric_limits<float>::infinity();
  glm::vec3 normal{0.0F};
};

// Composites one ray front to back.
class Ray {
 public:
  Ray(const RenderOptions& options, double unit)
      : end_(options.early_termination ? options.termination : 0), unit_(unit) {}

  // Adds the light that a part of a slab emits. Call it before pass() of the part.
  void glow(const glm::dvec3& light) { color_ += light_ * light; }
  // Adds a part of a slab. The whole slab extends from `first` to `last`. `taken` is 1 - exp(-sigma l), the opacity
  // of the part.
  void pass(const glm::vec4& entry, double taken, double first, double last) {
    add(glm::dvec3(entry), taken);
    if (!has_depth_ && light_ <= 0.5) settle(first + (last - first) / 2, glm::vec3(0));
  }
  void meet(const Shade& shade, double depth) {
    add(glm::dvec3(shade.color), shade.opacity);
    if (has_depth_) return;
    if (light_ <= 0.5) {
      settle(depth, shade.normal);
    } else if (!std::isfinite(pixel_.depth)) {
      // Takes the nearest surface for now; settle() replaces it if a later one hides half of the light.
      pixel_.depth = static_cast<float>(depth * unit_);
      pixel_.normal = shade.normal;
    }
  }
  [[nodiscard]] bool ended() const { return light_ <= 0 || light_ < end_; }

  [[nodiscard]] Pixel end(const glm::dvec4& background) {
    const double left = ended() ? 0 : light_;
    color_ += left * background.a * glm::dvec3(background);
    pixel_.color = glm::vec4(glm::dvec4(color_, 1 - left * (1 - background.a)));
    return pixel_;
  }

 private:
  void add(const glm::dvec3& color, double opacity) {
    color_ += light_ * opacity * color;
    light_ *= 1 - opacity;
  }
  void settle(double depth, const glm::vec3& normal) {
    has_depth_ = true;
    pixel_.depth = static_cast<float>(depth * unit_);
    pixel_.normal = normal;
  }

  double end_;
  double unit_;
  glm::dvec3 color_{0.0};
  double light_ = 1;  // transmittance so far
  bool has_depth_ = false;
  Pixel pixel_;
};

// How far a ray came.
struct RayProgress {
  std::span<const Fragment> fragments;  // fragments that the ray has not passed yet
  std::int64_t passed;                  // slabs passed; all of them unless the ray ended early
  std::int64_t samples = 0;             // samples taken

  [[nodiscard]] double next_fragment_depth() const {
    return fragments.empty() ? std::numeric_limits<double>::infinity() : fragments.front().depth;
  }
  // Adds the fragments up to `depth`. Returns whether the ray goes on.
  template <class Meet>
  bool add_fragments_until(double depth, const Ray& ray, const Meet& meet) {
    while (!ray.ended() && next_fragment_depth() <= depth) {
      meet(fragments.front());
      fragments = fragments.subspan(1);
    }
    return !ray.ended();
  }
};

// Returns the number of slabs between two depths. A remainder that is only rounding adds no slab.
inline std::int64_t count_slabs(double enter, double leave, double step) {
  return std::max(std::int64_t{1}, static_cast<std::int64_t>(std::ceil((leave - enter) / step - 1e-9)));
}

// Returns the cell of the slab's sample. A position on the upper face of the box belongs to the last cell.
inline glm::ivec3 cell_at(const SlabRay& way, std::int64_t k) {
  const double first = way.enter + double(k) * way.step;
  const double last = double(k + 1) < way.slabs ? way.enter + double(k + 1) * way.step : way.leave;
  const double middle = first + (last - first) / 2;
  glm::ivec3 cell;
  for (int axis = 0; axis < 3; ++axis) {
    const double index = std::clamp(way.eye[axis] + middle * way.along[axis], way.first[axis], way.greatest[axis]);
    const int whole = static_cast<int>(index);
    cell[axis] = index < whole ? whole - 1 : whole;
  }
  return cell;
}

// Returns the depths between which the ray is in the volume's box and between near and far; {0, 0} or the larger depth
// first if there are none. `along` is in index steps per depth.
inline std::pair<double, double> depths_in_box(const VolumeView& volume, const glm::dvec3& along, double near,
                                               double far) {
  double enter = near;
  double leave = far;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = volume.box.min[axis] - volume.eye[axis];
    const double high = volume.box.max[axis] - volume.eye[axis];
    if (along[axis] == 0) {
      if (low > 0 || high < 0) return {0, 0};
      continue;
    }
    const double a = low / along[axis];
    const double b = high / along[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return {enter, leave};
}

// Returns the first slab after k whose middle may lie beyond the brick; a slab too early is harmless.
inline std::int64_t next_slab(const glm::ivec3& brick, const SlabRay& way, std::int64_t k, std::int64_t slabs) {
  double leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (way.along[axis] == 0) continue;
    const int face = VolumeBricks::kCells * (brick[axis] + (way.along[axis] > 0 ? 1 : 0));
    leave = std::min(leave, (face - way.eye[axis]) / way.along[axis]);
  }
  constexpr double kRounding = 1e-9;
  const double number = (leave - way.enter) / way.step;
  const double next = std::ceil(number - 0.5 - kRounding * (1 + std::abs(number)));
  if (!(next > double(k + 1))) return k + 1;
  // The last slab is shorter, so its middle is closer.
  return next < double(slabs - 1) ? static_cast<std::int64_t>(next) : std::max(k + 1, slabs - 1);
}

}  // namespace isoextract::render::detail
