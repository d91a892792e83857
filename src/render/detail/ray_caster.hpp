// Casts rays through the volume and the surfaces: steps 2 to 7 of the model (renderer.hpp), without emission.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "render/detail/corner_reader.hpp"
#include "render/detail/ray_steps.hpp"

namespace isoextract::render::detail {

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
    const auto [enter, leave] = depths_in_box(volume_, along, near_, far_);
    if (!(leave > enter)) return fragments;
    ++statistics.rays;
    const double length = glm::length(direction) * volume_.unit;  // world units per depth
    const double step = volume_.step / length;
    const std::int64_t slabs = count_slabs(enter, leave, step);
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
      const std::int64_t next = next_slab(brick, way, k, slabs);
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
