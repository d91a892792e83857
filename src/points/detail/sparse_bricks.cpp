#include "points/detail/sparse_bricks.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include "base/checked.hpp"
#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "points/detail/brick_list.hpp"

namespace isoextract::points {
namespace {

constexpr int kSide = field::SparseBlock::kSize;
constexpr std::size_t kBrickSamples = std::size_t{kSide} * kSide * kSide;
constexpr int kTasks = 4;  // lists with more bricks than this are split into tasks

using Flags = Buffer<std::uint8_t>;

// Returns the bricks that contain a spot, each once and in order.
Result<BrickList> occupied_bricks(const CellGrid& grid, const Context& context, const std::string& label) {
  const auto brick_of = [&](std::size_t spot) {
    return glm::ivec3(glm::floor(grid.position(spot) / static_cast<double>(kSide)));
  };
  // Consecutive spots mostly share a brick, so only the first of each run is listed.
  constexpr std::size_t kChunk = 1 << 16;
  const std::size_t chunks = (grid.size() + kChunk - 1) / kChunk;
  const auto for_each_run_start = [&](std::size_t chunk, const auto& f) {
    for (std::size_t s = chunk * kChunk; s != std::min(grid.size(), (chunk + 1) * kChunk); ++s) {
      const glm::ivec3 brick = brick_of(s);
      if (s == 0 || brick != brick_of(s - 1)) f(brick);
    }
  };
  std::vector<std::size_t> ends(chunks + 1);
  for_each_index(chunks,
                 [&](std::size_t chunk) { for_each_run_start(chunk, [&](const glm::ivec3&) { ++ends[chunk + 1]; }); });
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) ends[chunk + 1] += ends[chunk];
  auto made = make_reserved_buffer<glm::ivec3>(ends[chunks], context, label);
  if (!made) return made;
  Buffer<glm::ivec3>& all = (*made)->values;
  for_each_index(chunks, [&](std::size_t chunk) {
    glm::ivec3* out = all.data() + ends[chunk];
    for_each_run_start(chunk, [&](const glm::ivec3& brick) { *out++ = brick; });
  });
  tbb::parallel_sort(all.begin(), all.end(), brick_before);
  const auto end = std::unique(all.begin(), all.end());
  return bricks_if(
      all.span().first(static_cast<std::size_t>(end - all.begin())), [](std::size_t) { return true; }, context, label);
}

// Returns the bricks for which keep(origin) holds; calls keep in parallel.
template <class F>
Result<BrickList> bricks_where(const BrickList& bricks, const char* stage, const F& keep, const Context& context,
                               const std::string& label) {
  const std::span<const glm::ivec3> list = std::as_const(bricks->values).span();
  auto flags = TRY(make_reserved_buffer<std::uint8_t>(list.size(), context, label));
  Flags& kept = flags->values;
  context.progress().begin(stage, list.size());
  for_each_range(list.size(), kTasks, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (std::size_t b = begin; b != end; ++b) {
      kept[b] = static_cast<std::uint8_t>(keep(list[b] * kSide));
    }
    context.progress().advance(end - begin);
  });
  TRY(context.check());
  return bricks_if(
      list, [&](std::size_t b) { return kept[b] != 0; }, context, label);
}

// Returns the bricks that can become tiles: they and all their neighbors are proved to be above `iso`.
Result<BrickList> bricks_far_inside(const BrickSource& source, const BrickList& bricks, double iso,
                                    const Context& context, const std::string& label) {
  auto likely = bricks_where(
      bricks, "looking for the inside", [&](const glm::ivec3& origin) { return source.is_probably_inside(origin); },
      context, label);
  if (!likely) return likely;
  // Only bricks next to a possible tile need a proof.
  auto hearts = eroded((*likely)->values.span(), context, label);
  if (!hearts) return hearts;
  auto worth = dilated((*hearts)->values.span(), 1, context, label);
  if (!worth) return worth;
  auto proved = bricks_where(
      *worth, "proving the inside", [&](const glm::ivec3& origin) { return source.is_proved_above(origin, iso); },
      context, label);
  if (!proved) return proved;
  return eroded((*proved)->values.span(), context, label);
}

// Returns the bricks that are not in `others`; both lists are sorted.
Result<BrickList> without(const BrickList& bricks, const BrickList& others, const Context& context,
                          const std::string& label) {
  const std::span<const glm::ivec3> list = std::as_const(bricks->values).span();
  const std::span<const glm::ivec3> removed = std::as_const(others->values).span();
  return bricks_if(
      list, [&](std::size_t b) { return !std::binary_search(removed.begin(), removed.end(), list[b], brick_before); },
      context, label);
}

// Bounds and count of the active voxels.
struct Active {
  glm::ivec3 min{std::numeric_limits<int>::max()};
  glm::ivec3 max{std::numeric_limits<int>::min()};
  std::uint64_t count = 0;

  void add(const glm::ivec3& low, const glm::ivec3& high, std::uint64_t voxels) {
    min = glm::min(min, low);
    max = glm::max(max, high);
    count += voxels;
  }
  void add_block(const glm::ivec3& origin, const float* values) {
    for (int row = 0; row < kSide * kSide; ++row) {
      std::uint32_t active = 0;  // a bit for each voxel of the row
      for (int k = 0; k < kSide; ++k) active |= static_cast<std::uint32_t>(values[row * kSide + k] != 0) << k;
      if (active == 0) continue;
      const glm::ivec3 start = origin + glm::ivec3(row / kSide, row % kSide, 0);
      add(start + glm::ivec3(0, 0, std::countr_zero(active)), start + glm::ivec3(0, 0, std::bit_width(active) - 1),
          static_cast<std::uint64_t>(std::popcount(active)));
    }
  }
};

// Fails before the work if even the bricks around one spot exceed memory, as with a fine spacing and a long reach.
Result<void> check_rings(int rings, const Context& context, const std::string& label) {
  const std::uint64_t side = 2 * static_cast<std::uint64_t>(rings) + 1;
  const auto bricks = checked_product(side * side, side);
  const auto bytes = bricks ? checked_product(*bricks, sizeof(glm::ivec3)) : std::nullopt;
  const auto fits =
      TRY(context.reserve(bytes.value_or(std::numeric_limits<std::uint64_t>::max()),
                          fmt::format("{}: {}^3 bricks of 8^3 samples around each particle", label, side)));
  return {};
}

// Returns whether the brick at `origin` has a sample in the box.
bool overlaps(const field::IndexBox& box, const glm::ivec3& origin) {
  return glm::all(glm::lessThanEqual(origin, box.max)) && glm::all(glm::lessThanEqual(box.min, origin + (kSide - 1)));
}

struct OwnedBricks {
  Buffer<float> values;
  Reservation memory;
};

}  // namespace

Result<field::SparseSamples> fill_bricks(const BrickSource& source, std::optional<double> iso, double inside,
                                         const std::optional<field::IndexBox>& needed, BrickCounts& counts,
                                         const Context& context, const std::string& label) {
  const std::string what = fmt::format("{}: the bricks around {} particles", label, source.grid().size());
  const int rings = static_cast<int>(std::ceil(source.reach() / kSide));
  TRY(check_rings(rings, context, label));
  auto bricks = occupied_bricks(source.grid(), context, what);
  if (bricks) bricks = dilated((*bricks)->values.span(), rings, context, what);
  if (bricks) {
    bricks = bricks_where(
        *bricks, "finding bricks",
        [&](const glm::ivec3& origin) { return (!needed || overlaps(*needed, origin)) && source.touches(origin); },
        context, what);
  }
  if (!bricks) return tl::unexpected(bricks.error());
  BrickList deep;
  if (iso) {
    deep = TRY(bricks_far_inside(source, *bricks, *iso, context, what));
    bricks = without(*bricks, deep, context, what);
    if (!bricks) return tl::unexpected(bricks.error());
  }
  const std::span<const glm::ivec3> list = std::as_const((*bricks)->values).span();
  counts.bricks_stored = list.size();
  counts.inside_tiles = deep ? deep->values.size() : 0;
  if (list.size() > std::size_t{std::numeric_limits<std::int32_t>::max()}) {
    return fail(
        ErrorCode::input,
        fmt::format("{}: {} bricks of 8^3 samples are more than the limit of 2^31 - 1 bricks", label, list.size()),
        {Remedy::raise, Setting::cell_size});
  }

  auto marks =
      TRY(make_reserved_buffer<std::uint8_t>(counts.inside_tiles != 0 ? source.grid().size() : 0, context, what));
  std::ranges::fill(marks->values, std::uint8_t{0});
  auto memory = TRY(context.reserve(list.size() * (kBrickSamples * sizeof(float) + sizeof(field::SparseBlock)) +
                                        counts.inside_tiles * sizeof(field::SparseTile),
                                    fmt::format("{}: {} bricks of 8^3 samples", label, list.size())));
  auto owned = std::make_shared<OwnedBricks>();
  owned->memory = std::move(memory);
  owned->values = Buffer<float>(list.size() * kBrickSamples);
  float* const values = owned->values.data();
  field::SparseSamples samples;
  samples.type = field::SampleType::f32;
  samples.blocks.resize(list.size());
  context.progress().begin("summing kernels", list.size());
  Active active = reduce_ranges(
      list.size(), kTasks, Active{},
      [&](std::size_t begin, std::size_t end, Active part) {
        if (context.cancelled()) return part;
        for (std::size_t b = begin; b != end; ++b) {
          float* const brick = values + b * kBrickSamples;
          source.fill(list[b] * kSide, brick, ContributingSpots(marks->values.data()));
          samples.blocks[b] = {list[b] * kSide, brick};
          part.add_block(list[b] * kSide, brick);
        }
        context.progress().advance(end - begin);
        return part;
      },
      [](Active a, const Active& b) {
        a.add(b.min, b.max, b.count);
        return a;
      });
  TRY(context.check());
  for (std::size_t t = 0; t < counts.inside_tiles; ++t) {
    const glm::ivec3 origin = deep->values[t] * kSide;
    samples.tiles.push_back({origin, kSide, inside});
    active.add(origin, origin + (kSide - 1), kBrickSamples);
  }
  for (std::size_t s = 0; s < marks->values.size(); ++s) {
    if (marks->values[s] == 0) counts.particles_deep_inside += source.particles_at(s);
  }
  if (active.count != 0) samples.active_box = {active.min, active.max};
  samples.active_voxels = active.count;
  samples.owner = std::move(owned);
  return samples;
}

}  // namespace isoextract::points
