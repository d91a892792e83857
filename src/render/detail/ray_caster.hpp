// Casts rays through the volume and the surfaces: steps 2 to 7 of the model (renderer.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include <glm/glm.hpp>

#include "render/detail/corner_reader.hpp"
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
  double step = 1;        // in world units
  double per_length = 1;  // transfer function lengths per world unit
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

// Casts rays through samples stored as T. Use one per thread.
template <class T>
class RayCaster {
 public:
  // Draws only surfaces if volume.samples is null.
  RayCaster(const VolumeView& volume, const SurfaceView& surfaces, const Scene& scene, const Camera& camera,
            const RenderOptions& options)
      : volume_(volume),
        surfaces_(surfaces),
        scene_(scene),
        options_(options),
        near_(camera.near_depth / camera.unit()),
        far_(camera.far_depth / camera.unit()),
        unit_(camera.unit()) {
    if (volume.samples != nullptr) corners_.emplace(*volume.samples);
  }

  // `within` tells whether the pixel may see the volume.
  [[nodiscard]] Pixel cast(const glm::dvec3& direction, std::span<const Fragment> fragments, bool within,
                           RenderStatistics& statistics) {
    Ray ray(options_, unit_);
    const auto meet = [&](const Fragment& fragment) {
      ray.meet(surfaces_.shade(fragment.triangle, direction), fragment.depth);
    };
    if (within && corners_) fragments = pass_volume(ray, direction, fragments, statistics, meet);
    for (const Fragment& fragment : fragments) {
      if (ray.ended()) break;
      meet(fragment);
    }
    return ray.end(scene_.background);
  }

 private:
  // Goes from brick to brick, collects the slabs of visible bricks, and composites them in full batches. Returns the
  // fragments that remain.
  template <class Meet>
  std::span<const Fragment> pass_volume(Ray& ray, const glm::dvec3& direction, std::span<const Fragment> fragments,
                                        RenderStatistics& statistics, const Meet& meet) {
    const glm::dvec3 along = volume_.index_of_view * direction;  // index steps per depth
    const auto [enter, leave] = limits(along);
    if (!(leave > enter)) return fragments;
    ++statistics.rays;
    const double length = glm::length(direction) * volume_.unit;  // world units per depth
    const double step = volume_.step / length;
    // A remainder that is only rounding adds no slab.
    const auto slabs = std::max(std::int64_t{1}, static_cast<std::int64_t>(std::ceil((leave - enter) / step - 1e-9)));
    const SlabRay way{enter,
                      leave,
                      step,
                      double(slabs),
                      length,
                      volume_.per_length,
                      volume_.eye,
                      along,
                      volume_.box.min,
                      volume_.box.max - 1.0};
    RayProgress state{fragments, slabs};
    batch_.size = 0;
    std::int64_t k = 0;
    while (k < slabs) {
      const double first = enter + double(k) * step;
      if (state.next_fragment_depth() <= first) {
        if (!composite(ray, way, state, meet)) break;
        if (!state.add_fragments_until(first, ray, meet)) {
          state.passed = k;
          break;
        }
      }
      const glm::ivec3 brick = cell_at(way, k) >> 3;
      const std::int64_t next = next_slab(brick, along, enter, step, k, slabs);
      if (volume_.bricks != nullptr && !volume_.bricks->is_visible(brick)) {
        k = next;
        continue;
      }
      while (k < next) {
        batch_.number[batch_.size++] = double(k++);
        if (batch_.size == SlabBatch::kSlabs && !composite(ray, way, state, meet)) break;
      }
      if (ray.ended()) break;
    }
    if (!ray.ended()) composite(ray, way, state, meet);
    statistics.samples += static_cast<std::uint64_t>(state.samples);
    statistics.samples_skipped += static_cast<std::uint64_t>(state.passed - state.samples);
    statistics.samples_terminated += static_cast<std::uint64_t>(slabs - state.passed);
    return state.fragments;
  }

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

  // Composites the slabs of the batch with the fragments among them, and empties the batch. Returns whether the ray
  // goes on.
  template <class Meet>
  bool composite(Ray& ray, const SlabRay& way, RayProgress& state, const Meet& meet) {
    if (batch_.size == 0) return true;
    place(way, batch_);
    corners_->shade(way, batch_);
    for (std::size_t i = 0; i < batch_.size; ++i) {
      const double first = batch_.first[i];
      const double last = batch_.last[i];
      if (state.next_fragment_depth() <= first && !state.add_fragments_until(first, ray, meet)) {
        state.passed = static_cast<std::int64_t>(batch_.number[i]);
        return false;
      }
      ++state.samples;
      if (!(batch_.sigma[i] > 0)) continue;
      if (state.next_fragment_depth() < last) {
        divide(ray, way, i, state, meet);
      } else {
        ray.pass(batch_.entry[i], batch_.opacity[i], first, last);
      }
      if (ray.ended()) {
        state.passed = static_cast<std::int64_t>(batch_.number[i]) + 1;
        return false;
      }
    }
    batch_.size = 0;
    return true;
  }

  // Composites a slab that contains fragments.
  template <class Meet>
  void divide(Ray& ray, const SlabRay& way, std::size_t slab, RayProgress& state, const Meet& meet) {
    const double first = batch_.first[slab];
    const double last = batch_.last[slab];
    const glm::vec4& entry = batch_.entry[slab];
    const double per_depth = batch_.sigma[slab] * way.length * way.per_length;
    double from = first;
    while (!ray.ended() && state.next_fragment_depth() < last) {
      const double to = state.next_fragment_depth();
      if (to > from) ray.pass(entry, 1 - std::exp(-per_depth * (to - from)), first, last);
      if (ray.ended()) return;
      meet(state.fragments.front());
      state.fragments = state.fragments.subspan(1);
      from = std::max(from, to);
    }
    if (!ray.ended()) ray.pass(entry, 1 - std::exp(-per_depth * (last - from)), first, last);
  }

  // Returns the cell of the slab's sample. A position on the upper face of the box belongs to the last cell.
  [[nodiscard]] static glm::ivec3 cell_at(const SlabRay& way, std::int64_t k) {
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

  // Returns the depths between which the ray is in the box and between near and far.
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

  // Returns the first slab whose middle may lie beyond the brick; a slab too early is harmless.
  [[nodiscard]] std::int64_t next_slab(const glm::ivec3& brick, const glm::dvec3& along, double enter, double step,
                                       std::int64_t k, std::int64_t slabs) const {
    double leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (along[axis] == 0) continue;
      const int face = VolumeBricks::kCells * (brick[axis] + (along[axis] > 0 ? 1 : 0));
      leave = std::min(leave, (face - volume_.eye[axis]) / along[axis]);
    }
    constexpr double kRounding = 1e-9;
    const double number = (leave - enter) / step;
    const double next = std::ceil(number - 0.5 - kRounding * (1 + std::abs(number)));
    if (!(next > double(k + 1))) return k + 1;
    // The last slab is shorter, so its middle is closer.
    return next < double(slabs - 1) ? static_cast<std::int64_t>(next) : std::max(k + 1, slabs - 1);
  }

  const VolumeView& volume_;
  const SurfaceView& surfaces_;
  const Scene& scene_;
  const RenderOptions& options_;
  double near_;
  double far_;
  double unit_;
  std::optional<CornerReader<T>> corners_;  // unset without a volume
  SlabBatch batch_;
};

}  // namespace isoextract::render::detail
