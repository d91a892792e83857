#include <memory>
#include <optional>

#include <tbb/enumerable_thread_specific.h>

#include "base/first_error.hpp"
#include "base/machine.hpp"
#include "base/parallel.hpp"
#include "render/detail/glowing_ray_caster.hpp"
#include "render/detail/ray_caster.hpp"
#include "render/detail/volume_pixels.hpp"
#include "render/renderer.hpp"

namespace isoextract::render {
namespace {

void add(RenderStatistics& sum, const RenderStatistics& part) {
  sum.rays += part.rays;
  sum.samples += part.samples;
  sum.samples_skipped += part.samples_skipped;
  sum.samples_terminated += part.samples_terminated;
  sum.fragments += part.fragments;
}

// Data that is prepared from a volume before rays are cast.
struct PreparedVolume {
  explicit PreparedVolume(detail::VolumeSamples opened) : samples(std::move(opened)) {}

  [[nodiscard]] static Result<std::unique_ptr<PreparedVolume>> make(const Volume& volume, bool skipping,
                                                                    const Context& context) {
    auto samples = TRY(detail::VolumeSamples::open(volume, context));
    auto made = std::make_unique<PreparedVolume>(std::move(samples));
    if (skipping) {
      auto bricks = TRY(detail::VolumeBricks::measure(made->samples, context));
      made->bricks.emplace(std::move(bricks));
    }
    if (volume.emission != nullptr) {
      made->emission = TRY(make(*volume.emission, skipping, context));
    }
    return made;
  }

  void count_bricks(RenderStatistics& statistics) const {
    if (bricks) {
      statistics.bricks += bricks->count();
      statistics.bricks_skipped += bricks->count_invisible();
    }
    if (emission) emission->count_bricks(statistics);
  }

  detail::VolumeSamples samples;
  std::optional<detail::VolumeBricks> bricks;  // of `samples`; unset if nothing is skipped
  std::unique_ptr<PreparedVolume> emission;    // null without Volume::emission
};

// Returns the volume as the camera sees it, without its emission. `lengths` is the volume whose step and unit length
// apply.
detail::VolumeView view_of(const Volume& volume, const PreparedVolume& prepared, const Volume& lengths,
                           const Camera& camera, const RenderOptions& options) {
  const field::Affine index_of_world = volume.index_to_world.inverse();
  detail::VolumeView view;
  view.samples = &prepared.samples;
  if (prepared.bricks) view.bricks = &*prepared.bricks;
  view.box = *volume_box(*volume.field);
  view.eye = index_of_world(camera.eye);
  view.index_of_view = index_of_world.linear * camera.world_from_view().linear;
  view.unit = camera.unit();
  view.step = step_of(lengths, options);
  view.per_length = 1 / lengths.unit_length;
  return view;
}

class CpuRenderer : public Renderer {
 public:
  Result<Rendered> draw(const Scene& scene, const Camera& camera, const RenderOptions& options,
                        const Context& context) override {
    TRY(check(scene, camera, options));
    Rendered rendered;
    rendered.picture = TRY(make_picture(options.size.width, options.size.height, context));

    const detail::SurfaceView surfaces(scene, camera, options.size);
    const auto tiles = TRY(detail::SurfaceTiles::sort(surfaces, camera, options.size, context));

    detail::VolumeView volume;
    detail::VolumeView emission;
    std::unique_ptr<PreparedVolume> own;  // used for this picture only
    PixelBox within;
    if (scene.volume != nullptr) {
      const bool keeps = scene.volume == to_keep_;
      std::unique_ptr<PreparedVolume>& prepared = keeps ? kept_ : own;
      rendered.reused_volume = prepared != nullptr && prepared->bricks.has_value() == options.empty_space_skipping;
      if (!rendered.reused_volume) {
        prepared.reset();
        prepared = TRY(PreparedVolume::make(*scene.volume, options.empty_space_skipping, context));
      }
      prepared->count_bricks(rendered.statistics);
      volume = view_of(*scene.volume, *prepared, *scene.volume, camera, options);
      if (scene.volume->emission != nullptr) {
        emission = view_of(*scene.volume->emission, *prepared->emission, *scene.volume, camera, options);
        volume.emission = &emission;
      }
      within = detail::pixels_of(camera, options.size, *scene.volume);
    }

    const Work work{scene, camera, options, context, surfaces, tiles, volume, within};
    FirstError failure;
    if (volume.emission != nullptr) {
      draw_tiles<detail::GlowingRayCaster>(work, rendered, failure);
    } else {
      const auto type = scene.volume != nullptr ? scene.volume->field->type() : field::SampleType::f32;
      field::visit_sample_type(
          type, [&]<class T>(std::type_identity<T>) { draw_tiles<detail::RayCaster<T>>(work, rendered, failure); });
    }
    if (failure.error()) return tl::unexpected(std::move(*failure.error()));
    TRY(context.check());
    return rendered;
  }

  void keep(const Volume* volume) override {
    kept_.reset();
    to_keep_ = volume;
  }

  [[nodiscard]] std::string device() const override { return "CPU, " + cpu_name(); }

 private:
  struct Work {
    const Scene& scene;
    const Camera& camera;
    const RenderOptions& options;
    const Context& context;
    const detail::SurfaceView& surfaces;
    const detail::SurfaceTiles& tiles;
    const detail::VolumeView& volume;
    const PixelBox& within;
  };

  template <class Caster>
  static void draw_tiles(const Work& work, Rendered& rendered, FirstError& failure) {
    struct Local {
      explicit Local(const Work& work)
          : fragments(work.context), caster(work.volume, work.surfaces, work.scene, work.camera, work.options) {}

      detail::TileFragments fragments;
      Caster caster;
      RenderStatistics statistics;
    };
    tbb::enumerable_thread_specific<Local> locals([&] { return Local(work); });
    const detail::TileGrid grid(work.options.size);
    work.context.progress().begin("drawing", grid.count());
    for_each_index(grid.count(), [&](std::size_t number) {
      if (failure.any() || work.context.cancelled()) return;
      Local& local = locals.local();
      if (auto drawn = work.tiles.draw(number, local.fragments); !drawn) {
        failure.keep(std::move(drawn.error()));
        return;
      }
      local.statistics.fragments += local.fragments.met();
      const detail::Tile tile = grid.at(number);
      for (int y = tile.min.y; y < tile.max.y; ++y) {
        for (int x = tile.min.x; x < tile.max.x; ++x) {
          const bool within =
              x >= work.within.min.x && x < work.within.max.x && y >= work.within.min.y && y < work.within.max.y;
          const int in_tile = x - tile.min.x + detail::Tile::kSide * (y - tile.min.y);
          const auto of_tile = static_cast<std::size_t>(in_tile);
          const detail::Pixel pixel = local.caster.cast(work.surfaces.direction(x + 0.5, y + 0.5),
                                                        local.fragments.of(of_tile), within, local.statistics);
          const std::size_t at = static_cast<std::size_t>(x) +
                                 static_cast<std::size_t>(work.options.size.width) * static_cast<std::size_t>(y);
          rendered.picture.color[at] = pixel.color;
          rendered.picture.depth[at] = pixel.depth;
          rendered.picture.normals[at] = pixel.normal;
        }
      }
      work.context.progress().advance(1);
    });
    for (const Local& local : locals) add(rendered.statistics, local.statistics);
  }

  const Volume* to_keep_ = nullptr;
  std::unique_ptr<PreparedVolume> kept_;  // prepared from that volume
};

}  // namespace

std::unique_ptr<Renderer> make_cpu_renderer() { return std::make_unique<CpuRenderer>(); }

}  // namespace isoextract::render
