#include "render/visible_box.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <numeric>
#include <optional>
#include <vector>

#include "base/parallel.hpp"
#include "render/detail/volume_samples.hpp"

namespace isoextract::render {
namespace {

constexpr double kBeyond = 0.001;  // share of the extinction beyond each face of the box

// Sums of the extinctions of the samples in each plane of samples across an axis.
using PlaneSums = std::array<std::vector<double>, 3>;

PlaneSums no_sums(const field::IndexBox& box) {
  PlaneSums sums;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int a = static_cast<int>(axis);
    sums[axis].resize(static_cast<std::size_t>(box.dims()[a]));
  }
  return sums;
}

void add(PlaneSums& sums, const PlaneSums& others) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::ranges::transform(sums[axis], others[axis], sums[axis].begin(), std::plus<>());
  }
}

// Adds the samples of `part`, which lies within `box`.
template <class T>
void add_samples(const detail::VolumeSamples& samples, const field::IndexBox& part, const field::IndexBox& box,
                 PlaneSums& sums) {
  detail::SampleReader<T> reader(samples);
  for (int z = part.min.z; z <= part.max.z; ++z) {
    for (int y = part.min.y; y <= part.max.y; ++y) {
      double row = 0;
      for (int x = part.min.x; x <= part.max.x; ++x) {
        const double sigma = samples.transfer().lookup(reader({x, y, z})).a;
        sums[0][static_cast<std::size_t>(x - box.min.x)] += sigma;
        row += sigma;
      }
      sums[1][static_cast<std::size_t>(y - box.min.y)] += row;
      sums[2][static_cast<std::size_t>(z - box.min.z)] += row;
    }
  }
}

template <class T>
PlaneSums sums_of(const detail::VolumeSamples& samples, const field::IndexBox& box) {
  const PlaneSums none = no_sums(box);
  const auto join = [](PlaneSums earlier, const PlaneSums& later) {
    add(earlier, later);
    return earlier;
  };
  if (samples.dense() != nullptr) {
    const auto planes = static_cast<std::size_t>(box.dims().z);
    return reduce_ranges(
        planes, 8, none,
        [&](std::size_t begin, std::size_t end, PlaneSums sums) {
          add_samples<T>(samples,
                         {{box.min.x, box.min.y, box.min.z + static_cast<int>(begin)},
                          {box.max.x, box.max.y, box.min.z + static_cast<int>(end) - 1}},
                         box, sums);
          return sums;
        },
        join);
  }
  const auto& blocks = samples.sparse().blocks;
  return reduce_ranges(
      blocks.size(), 1024, none,
      [&](std::size_t begin, std::size_t end, PlaneSums sums) {
        for (std::size_t n = begin; n < end; ++n) {
          const glm::ivec3 origin = blocks[n].origin;
          const field::IndexBox part{glm::max(origin, box.min),
                                     glm::min(origin + field::SparseBlock::kSize - 1, box.max)};
          if (!part.empty()) add_samples<T>(samples, part, box, sums);
        }
        return sums;
      },
      join);
}

bool has_visible_tile(const detail::VolumeSamples& samples) {
  return samples.dense() == nullptr && std::ranges::any_of(samples.sparse().tiles, [&](const field::SparseTile& tile) {
           return samples.transfer().lookup(samples.position(tile.value)).a > 0;
         });
}

// Returns the box of the visible samples in index space, enlarged by one voxel; the whole box if a tile is visible, and
// nothing if no sample is.
Result<std::optional<field::Box>> visible_box(const Volume& volume, const Context& context) {
  const auto samples = TRY(detail::VolumeSamples::open(volume, context));
  if (has_visible_tile(samples)) return std::optional(*volume_box(*volume.field));
  const field::IndexBox box = volume.field->extents();
  PlaneSums sums;
  field::visit_sample_type(samples.field().type(),
                           [&]<class T>(std::type_identity<T>) { sums = sums_of<T>(samples, box); });
  TRY(context.check());
  field::Box visible;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int a = static_cast<int>(axis);
    const double beyond = kBeyond * std::accumulate(sums[axis].begin(), sums[axis].end(), 0.0);
    if (!(beyond > 0)) return std::nullopt;
    const auto planes_before = [&](auto begin, auto end) {
      double sum = 0;
      return std::find_if(begin, end, [&](double plane) { return (sum += plane) > beyond; }) - begin;
    };
    visible.min[a] = box.min[a] + static_cast<double>(planes_before(sums[axis].begin(), sums[axis].end())) - 1;
    visible.max[a] = box.max[a] - static_cast<double>(planes_before(sums[axis].rbegin(), sums[axis].rend())) + 1;
  }
  return visible;
}

// Returns the visible part of a volume or an emission in the world; nothing if no sample is visible.
Result<std::optional<field::Box>> visible_in_world(const Volume& volume, const Context& context) {
  const field::Box whole = TRY(volume_box(*volume.field));
  const auto visible = TRY(visible_box(volume, context));
  if (!visible) return std::nullopt;
  return field::image_of(volume.index_to_world,
                         field::Box{glm::max(whole.min, visible->min), glm::min(whole.max, visible->max)});
}

field::Box around(const field::Box& a, const field::Box& b) { return {glm::min(a.min, b.min), glm::max(a.max, b.max)}; }

}  // namespace

Result<field::Box> visible_box_of(const Scene& scene, const Context& context) {
  if (scene.volume == nullptr) return box_of(scene);
  auto visible = TRY(visible_in_world(*scene.volume, context));
  if (scene.volume->emission != nullptr) {
    const auto glowing = TRY(visible_in_world(*scene.volume->emission, context));
    if (glowing) visible = visible ? around(*visible, *glowing) : *glowing;
  }
  if (!visible) return box_of(scene);
  field::Box box = *visible;
  Scene surfaces = scene;
  surfaces.volume = nullptr;
  const bool has_vertices =
      std::ranges::any_of(scene.surfaces, [](const Surface& surface) { return !surface.mesh->positions.empty(); });
  if (has_vertices) {
    const field::Box meshes = TRY(box_of(surfaces));
    box = around(box, meshes);
  }
  return box;
}

}  // namespace isoextract::render
