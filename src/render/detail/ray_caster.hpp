// One ray after the other through the volume and past the surfaces: steps 2 to 7 of the model (renderer.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include <glm/glm.hpp>

#include "render/detail/surface_tiles.hpp"
#include "render/detail/surface_view.hpp"
#include "render/detail/volume_bricks.hpp"
#include "render/detail/volume_samples.hpp"
#include "render/renderer.hpp"

namespace isoextract::render::detail {

// The volume as the camera's rays meet it. Depths are in units of Camera::unit().
struct VolumeView {
  const VolumeSamples* samples = nullptr;
  const VolumeBricks* bricks = nullptr;  // null: nothing is skipped
  field::Box box;                        // in index space
  glm::dvec3 eye{0.0};                   // likewise
  glm::dmat3 index_of_view{1.0};         // of directions
  double unit = 1;
  double step = 1;        // in the world
  double per_length = 1;  // unit lengths of the transfer function in one of the world
};

struct Pixel {
  glm::vec4 colour{0.0F};  // premultiplied
  float depth = std::numeric_limits<float>::infinity();
  glm::vec3 normal{0.0F};
};

// What has come together on the way of one ray.
class Ray {
 public:
  Ray(const RenderOptions& options, double unit)
      : end_(options.early_termination ? options.termination : 0), unit_(unit) {}

  // A part of a slab: `taken` is 1 - exp(-sigma l).
  void pass(const glm::vec4& entry, double taken, double middle) {
    add(glm::dvec3(entry), taken);
    if (!settled_ && light_ <= 0.5) settle(middle, glm::vec3(0));
  }
  void meet(const Shade& shade, double depth) {
    add(glm::dvec3(shade.colour), shade.opacity);
    if (settled_) return;
    if (light_ <= 0.5) {
      settle(depth, shade.normal);
    } else if (!std::isfinite(pixel_.depth)) {
      // The nearest one's, unless something hides more.
      pixel_.depth = static_cast<float>(depth * unit_);
      pixel_.normal = shade.normal;
    }
  }
  [[nodiscard]] bool ended() const { return light_ <= 0 || light_ < end_; }

  [[nodiscard]] Pixel end(const glm::dvec4& background) {
    const double left = ended() ? 0 : light_;
    colour_ += left * background.a * glm::dvec3(background);
    pixel_.colour = glm::vec4(glm::dvec4(colour_, 1 - left * (1 - background.a)));
    return pixel_;
  }

 private:
  void add(const glm::dvec3& colour, double opacity) {
    colour_ += light_ * opacity * colour;
    light_ *= 1 - opacity;
  }
  void settle(double depth, const glm::vec3& normal) {
    settled_ = true;
    pixel_.depth = static_cast<float>(depth * unit_);
    pixel_.normal = normal;
  }

  double end_;
  double unit_;
  glm::dvec3 colour_{0.0};
  double light_ = 1;  // that is left
  bool settled_ = false;
  Pixel pixel_;
};

// Of samples stored as T: one a thread.
template <class T>
class RayCaster {
 public:
  // `volume` may have no samples: then there are surfaces only.
  RayCaster(const VolumeView& volume, const SurfaceView& surfaces, const Scene& scene, const Camera& camera,
            const RenderOptions& options)
      : volume_(volume),
        surfaces_(surfaces),
        scene_(scene),
        options_(options),
        near_(camera.near_depth / camera.unit()),
        far_(camera.far_depth / camera.unit()),
        unit_(camera.unit()) {
    if (volume.samples != nullptr) {
      cursor_.emplace(*volume.samples, glm::ivec3(volume.box.min), glm::ivec3(volume.box.max) - 1);
    }
  }

  // `within`: whether the pixel may see the volume.
  [[nodiscard]] Pixel cast(const glm::dvec3& direction, std::span<const Fragment> fragments, bool within,
                           RenderStatistics& statistics) {
    Ray ray(options_, unit_);
    const auto meet = [&](const Fragment& fragment) {
      ray.meet(surfaces_.shade(fragment.triangle, direction), fragment.depth);
    };
    if (within && cursor_) fragments = pass_volume(ray, direction, fragments, statistics, meet);
    for (const Fragment& fragment : fragments) {
      if (ray.ended()) break;
      meet(fragment);
    }
    return ray.end(scene_.background);
  }

 private:
  // Returns the fragments that are left.
  template <class Meet>
  std::span<const Fragment> pass_volume(Ray& ray, const glm::dvec3& direction, std::span<const Fragment> fragments,
                                        RenderStatistics& statistics, const Meet& meet) {
    const glm::dvec3 along = volume_.index_of_view * direction;  // index steps per depth
    const auto [enter, leave] = limits(along);
    if (!(leave > enter)) return fragments;
    ++statistics.rays;
    const double length = glm::length(direction) * volume_.unit;  // world units per depth
    const double step = volume_.step / length;
    // No further slab for what is only rounding.
    const auto slabs = std::max(std::int64_t{1}, static_cast<std::int64_t>(std::ceil((leave - enter) / step - 1e-9)));
    const TransferFunction& transfer = volume_.samples->transfer();
    glm::ivec3 seen_brick(std::numeric_limits<int>::min());
    for (std::int64_t k = 0; k < slabs; ++k) {
      const double first = enter + double(k) * step;
      const double last = k + 1 < slabs ? enter + double(k + 1) * step : leave;
      while (!ray.ended() && !fragments.empty() && fragments.front().depth <= first) {
        meet(fragments.front());
        fragments = fragments.subspan(1);
      }
      if (ray.ended()) {
        statistics.samples_terminated += static_cast<std::uint64_t>(slabs - k);
        return fragments;
      }
      const double middle = first + (last - first) / 2;
      const glm::dvec3 index = volume_.eye + middle * along;
      const glm::ivec3 cell = cursor_->cell_of(index);
      if (volume_.bricks != nullptr) {
        const glm::ivec3 brick = cell >> 3;
        if (brick != seen_brick) {
          if (!volume_.bricks->seen(brick)) {
            const std::int64_t next = next_slab(brick, along, enter, step, k, slabs);
            statistics.samples_skipped += static_cast<std::uint64_t>(next - k);
            k = next - 1;
            continue;
          }
          seen_brick = brick;
        }
      }
      ++statistics.samples;
      const glm::vec4 entry = transfer.lookup((*cursor_)(index, cell));
      if (!(entry.a > 0)) continue;
      const double per_depth = entry.a * length * volume_.per_length;
      double from = first;
      while (!ray.ended() && !fragments.empty() && fragments.front().depth < last) {
        const double to = fragments.front().depth;
        if (to > from) ray.pass(entry, 1 - std::exp(-per_depth * (to - from)), middle);
        if (ray.ended()) break;
        meet(fragments.front());
        fragments = fragments.subspan(1);
        from = std::max(from, to);
      }
      if (!ray.ended()) ray.pass(entry, 1 - std::exp(-per_depth * (last - from)), middle);
      if (ray.ended()) {
        statistics.samples_terminated += static_cast<std::uint64_t>(slabs - k - 1);
        return fragments;
      }
    }
    return fragments;
  }

  // Depths at which the ray is in the box, and between near and far.
  [[nodiscard]] std::pair<double, double> limits(const glm::dvec3& along) const {
    double enter = near_;
    double leave = far_;
    for (int axis = 0; axis < 3; ++axis) {
      const double low = volume_.box.min[axis] - volume_.eye[axis];
      const double high = volume_.box.max[axis] - volume_.eye[axis];
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

  // The first slab that may have its middle beyond the brick: one too early does no harm.
  [[nodiscard]] std::int64_t next_slab(const glm::ivec3& brick, const glm::dvec3& along, double enter, double step,
                                       std::int64_t k, std::int64_t slabs) const {
    double leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (along[axis] == 0) continue;
      const int border = VolumeBricks::kCells * (brick[axis] + (along[axis] > 0 ? 1 : 0));
      leave = std::min(leave, (border - volume_.eye[axis]) / along[axis]);
    }
    constexpr double kRounding = 1e-9;
    const double number = (leave - enter) / step;
    const double next = std::ceil(number - 0.5 - kRounding * (1 + std::abs(number)));
    if (!(next > double(k + 1))) return k + 1;
    // The last slab is shorter, so its middle is nearer.
    return next < double(slabs - 1) ? static_cast<std::int64_t>(next) : std::max(k + 1, slabs - 1);
  }

  const VolumeView& volume_;
  const SurfaceView& surfaces_;
  const Scene& scene_;
  const RenderOptions& options_;
  double near_;
  double far_;
  double unit_;
  std::optional<PositionCursor<T>> cursor_;
};

}  // namespace isoextract::render::detail
