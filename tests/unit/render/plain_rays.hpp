// Casts rays sample by sample in plain C++, as the reference for the vectorized rays.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "render/detail/ray_caster.hpp"
#include "unit/render/drawing.hpp"

namespace isoextract::render::detail {

// The trilinear interpolant; caches the last cell, since consecutive samples mostly share it.
template <class T>
class PlainInterpolant {
 public:
  // `last` is the last cell of the volume's box.
  PlainInterpolant(const VolumeSamples& samples, const glm::ivec3& first, const glm::ivec3& last)
      : reader_(samples), first_(first), last_(last) {}

  [[nodiscard]] float operator()(const glm::dvec3& index, const glm::ivec3& cell) {
    if (!loaded_ || cell != cell_) {
      loaded_ = true;
      cell_ = cell;
      for (int n = 0; n < 8; ++n)
        at_[static_cast<std::size_t>(n)] = reader_(cell + glm::ivec3(n & 1, n >> 1 & 1, n >> 2));
    }
    const glm::vec3 t(index - glm::dvec3(cell));
    const auto between = [](float a, float b, float share) { return a + share * (b - a); };
    const float low = between(between(at_[0], at_[1], t.x), between(at_[2], at_[3], t.x), t.y);
    const float high = between(between(at_[4], at_[5], t.x), between(at_[6], at_[7], t.x), t.y);
    return between(low, high, t.z);
  }

  // A position on the upper face belongs to the last cell.
  [[nodiscard]] glm::ivec3 cell_of(const glm::dvec3& index) const {
    return glm::clamp(glm::ivec3(glm::floor(index)), first_, last_);
  }

 private:
  SampleReader<T> reader_;
  glm::ivec3 first_;
  glm::ivec3 last_;
  bool loaded_ = false;
  glm::ivec3 cell_{0};
  std::array<float, 8> at_{};
};

// Casts rays through samples stored as T.
template <class T>
class PlainRays {
 public:
  PlainRays(const VolumeView& volume, const SurfaceView& surfaces, const Scene& scene, const Camera& camera,
            const RenderOptions& options)
      : volume_(volume),
        surfaces_(surfaces),
        scene_(scene),
        options_(options),
        near_(camera.near_depth / camera.unit()),
        far_(camera.far_depth / camera.unit()),
        unit_(camera.unit()),
        cursor_(*volume.samples, glm::ivec3(volume.box.min), glm::ivec3(volume.box.max) - 1) {}

  [[nodiscard]] Pixel cast(const glm::dvec3& direction, std::span<const Fragment> fragments,
                           RenderStatistics& statistics) {
    Ray ray(options_, unit_);
    const auto meet = [&](const Fragment& fragment) {
      ray.meet(surfaces_.shade(fragment.triangle, direction), fragment.depth);
    };
    fragments = pass_volume(ray, direction, fragments, statistics, meet);
    for (const Fragment& fragment : fragments) {
      if (ray.ended()) break;
      meet(fragment);
    }
    return ray.end(scene_.background);
  }

 private:
  // Returns the fragments that remain.
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
      const glm::ivec3 cell = cursor_.cell_of(index);
      if (volume_.bricks != nullptr) {
        const glm::ivec3 brick = cell >> 3;
        if (brick != seen_brick) {
          if (!volume_.bricks->is_visible(brick)) {
            const std::int64_t next = next_slab(brick, along, enter, step, k, slabs);
            statistics.samples_skipped += static_cast<std::uint64_t>(next - k);
            k = next - 1;
            continue;
          }
          seen_brick = brick;
        }
      }
      ++statistics.samples;
      const glm::vec4 entry = transfer.lookup(cursor_(index, cell));
      if (!(entry.a > 0)) continue;
      const double per_depth = entry.a * length * volume_.per_length;
      double from = first;
      while (!ray.ended() && !fragments.empty() && fragments.front().depth < last) {
        const double to = fragments.front().depth;
        if (to > from) ray.pass(entry, 1 - std::exp(-per_depth * (to - from)), first, last);
        if (ray.ended()) break;
        meet(fragments.front());
        fragments = fragments.subspan(1);
        from = std::max(from, to);
      }
      if (!ray.ended()) ray.pass(entry, 1 - std::exp(-per_depth * (last - from)), first, last);
      if (ray.ended()) {
        statistics.samples_terminated += static_cast<std::uint64_t>(slabs - k - 1);
        return fragments;
      }
    }
    return fragments;
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
  PlainInterpolant<T> cursor_;
};

}  // namespace isoextract::render::detail

namespace isoextract::test {

// Draws a scene with a volume.
template <class T>
render::Rendered draw_plainly(const render::Scene& scene, const render::Camera& camera,
                              const render::RenderOptions& options) {
  const Context context;
  const render::Volume& volume = *scene.volume;
  render::Rendered rendered{*render::make_picture(options.size.width, options.size.height, context), {}};
  const render::detail::SurfaceView surfaces(scene, camera, options.size);
  const auto tiles = *render::detail::SurfaceTiles::sort(surfaces, camera, options.size, context);
  const auto samples = *render::detail::VolumeSamples::open(volume, context);
  const auto bricks = *render::detail::VolumeBricks::measure(samples, context);
  const field::Affine index_of_world = volume.index_to_world.inverse();
  render::detail::VolumeView view;
  view.samples = &samples;
  if (options.empty_space_skipping) {
    view.bricks = &bricks;
    rendered.statistics.bricks = bricks.count();
    rendered.statistics.bricks_skipped = bricks.count_invisible();
  }
  view.box = *render::volume_box(*volume.field);
  view.eye = index_of_world(camera.eye);
  view.index_of_view = index_of_world.linear * camera.world_from_view().linear;
  view.unit = camera.unit();
  view.step = render::step_of(volume, options);
  view.per_length = 1 / volume.unit_length;
  render::detail::PlainRays<T> rays(view, surfaces, scene, camera, options);
  render::detail::TileFragments fragments(context);
  const render::detail::TileGrid grid(options.size);
  for (std::size_t number = 0; number < grid.count(); ++number) {
    EXPECT_TRUE(tiles.draw(number, fragments));
    rendered.statistics.fragments += fragments.met();
    const render::detail::Tile tile = grid.at(number);
    for (int y = tile.min.y; y < tile.max.y; ++y) {
      for (int x = tile.min.x; x < tile.max.x; ++x) {
        const int in_tile = x - tile.min.x + render::detail::Tile::kSide * (y - tile.min.y);
        const render::detail::Pixel pixel = rays.cast(
            surfaces.direction(x + 0.5, y + 0.5), fragments.of(static_cast<std::size_t>(in_tile)), rendered.statistics);
        const std::size_t at = pixel_of(rendered.picture, x, y);
        rendered.picture.color[at] = pixel.color;
        rendered.picture.depth[at] = pixel.depth;
        rendered.picture.normals[at] = pixel.normal;
      }
    }
  }
  return rendered;
}

}  // namespace isoextract::test
