#include "extract/sparse_sites.hpp"

#include <algorithm>
#include <atomic>

#include <fmt/format.h>

#include "extract/mesh_assembly.hpp"

namespace isoextract {
namespace {

constexpr int kSize = SparseBlock::kSize;
constexpr int kBlockSamples = kSize * kSize * kSize;

}  // namespace

Result<IndexBox> sparse_region(const ScalarField& field, const SparseSamples& samples, const ExtractOptions& options) {
  const IndexBox stored = stored_box(samples);
  if (stored.empty()) return stored;
  if (glm::any(glm::lessThan(stored.min, glm::ivec3(-kMaxSparseIndex))) ||
      glm::any(glm::greaterThan(stored.max, glm::ivec3(kMaxSparseIndex)))) {
    return fail(ErrorKind::input,
                fmt::format("{}: voxels lie farther than {} from index 0", field.source, kMaxSparseIndex));
  }
  IndexBox reach{stored.min - 1, stored.max + 1};
  // Where the background itself is inside, a region's cap must stand where the region ends.
  if (options.region && InsideRule{field.kind, options.iso}(field.scale(samples.background))) {
    reach = {glm::ivec3(-kMaxSparseIndex), glm::ivec3(kMaxSparseIndex)};
  }
  return clip_region(field, reach, options);
}

SparseSites::SparseSites(const ScalarField& field, const SparseSamples& samples, const IndexBox& region,
                         const ExtractOptions& options)
    : field_(field),
      samples_(samples),
      region_(region),
      options_(options),
      rule_{field.kind, options.iso},
      lookup_(samples),
      stored_number_(visit_sample_type(samples.type, []<class T>(std::type_identity<T>) {
        return +[](const void* values, int offset) {
          return static_cast<double>(static_cast<const T*>(values)[offset]);
        };
      })) {}

Result<void> SparseSites::find(ExtractStats& stats) {
  stats.brick = "8x8x8 voxels";
  stats.bricks = samples_.blocks.size();
  if (auto fits = check_memory(tile_skin_bytes(samples_, rule_, field_.scale), options_.limits,
                               fmt::format("{}: the skins of its {} tiles", field_.source, samples_.tiles.size()));
      !fits) {
    return fits;
  }
  const Stopwatch watch;
  visit_sample_type(samples_.type, [&]<class T>(std::type_identity<T>) { classify<T>(stats); });
  if (stats.nan_samples != 0 && options_.nan == NanPolicy::error) {
    return nan_error(field_, stats.nan_samples, first_nan());
  }
  has_holes_ = stats.nan_samples != 0 && options_.nan == NanPolicy::hole;
  list_sites();
  stats.bricks_visited = stored_sites_;
  stats.places_visited = sites_.size() - stored_sites_;
  stats.classify = watch.elapsed();
  return {};
}

template <class T>
void SparseSites::classify(ExtractStats& stats) {
  const std::size_t blocks = samples_.blocks.size();
  bits_ = Buffer<BlockBits>(blocks);
  const auto threshold = find_inside_threshold<T>(rule_, field_.scale);
  const InsideClassifier<T> classifier(threshold.value_or(InsideThreshold<T>{}));
  std::atomic<std::uint64_t> nan{0};
  for_each("classifying blocks", blocks, [&](std::size_t b) {
    std::uint64_t block_nan = 0;
    for (int x = 0; x < kSize; ++x) {
      bits_[b][x] = classifier(static_cast<const T*>(samples_.blocks[b].values) + 64 * x, 64, block_nan);
      if (!threshold) bits_[b][x] = 0;
    }
    if (block_nan != 0 && touches_region(samples_.blocks[b].origin, kSize)) {
      nan.fetch_add(block_nan, std::memory_order_relaxed);
    }
  });
  stats.samples_classified = blocks * kBlockSamples;
  stats.nan_samples = nan.load();
  for (const SparseTile& tile : samples_.tiles) {
    if (!std::isnan(tile.value) || !touches_region(tile.origin, tile.size)) continue;
    const auto side = static_cast<std::uint64_t>(tile.size);
    stats.nan_samples += side * side * side;
  }
  stats.nan_samples += std::isnan(samples_.background) ? 1 : 0;
}

// NaN is looked for in what a region touches only.
bool SparseSites::touches_region(const glm::ivec3& origin, int size) const {
  return glm::all(glm::lessThanEqual(origin, region_.max)) &&
         glm::all(glm::greaterThanEqual(origin + (size - 1), region_.min));
}

glm::ivec3 SparseSites::first_nan() const {
  for (const SparseBlock& block : samples_.blocks) {
    if (!touches_region(block.origin, kSize)) continue;
    for (int v = 0; v < kBlockSamples; ++v) {
      if (std::isnan(stored_number_(block.values, v))) return block.origin + glm::ivec3(v >> 6, v >> 3 & 7, v & 7);
    }
  }
  for (const SparseTile& tile : samples_.tiles) {
    if (std::isnan(tile.value) && touches_region(tile.origin, tile.size)) return tile.origin;
  }
  return stored_box(samples_).max + 1;  // only the background is left
}

// The bits of the block-size place at `origin`, stored or not.
const BlockBits* SparseSites::place_bits(const glm::ivec3& origin) const {
  static constexpr BlockBits kOutside{};
  static constexpr BlockBits kInside = [] {
    BlockBits bits{};
    bits.fill(~std::uint64_t{0});
    return bits;
  }();
  const std::int32_t block = lookup_.block(origin);
  if (block >= 0) return &bits_[static_cast<std::size_t>(block)];
  return rule_(field_.scale(lookup_.constant(origin))) ? &kInside : &kOutside;
}

SparseSites::Group SparseSites::group_bits(const glm::ivec3& origin) const {
  Group group;
  for (int n = 0; n < 8; ++n) group[n] = place_bits(origin + kSize * direction_step(n));
  return group;
}

double SparseSites::value(const glm::ivec3& p) const {
  const glm::ivec3 origin = block_origin(p);
  const std::int32_t block = lookup_.block(origin);
  if (block < 0) return field_.scale(lookup_.constant(origin));
  return field_.scale(stored_number_(samples_.blocks[static_cast<std::size_t>(block)].values, block_offset(p)));
}

// The samples of word x whose position plus `step` is still in the region.
std::uint64_t SparseSites::region_bits(const glm::ivec3& origin, const glm::ivec3& step, int x) const {
  const glm::ivec3 low = region_.min - origin;
  const glm::ivec3 high = region_.max - step - origin;
  if (x < low.x || x > high.x) return 0;
  std::uint64_t bits = 0;
  for (int y = std::max(low.y, 0); y <= std::min(high.y, kSize - 1); ++y) {
    for (int z = std::max(low.z, 0); z <= std::min(high.z, kSize - 1); ++z) bits |= std::uint64_t{1} << (8 * y + z);
  }
  return bits;
}

bool SparseSites::wholly_in_region(const glm::ivec3& origin) const {
  return glm::all(glm::greaterThanEqual(origin, region_.min)) &&
         glm::all(glm::lessThanEqual(origin + kSize, region_.max));
}

// The bits of the eight corners of the cells of word x.
RowBits::Corners SparseSites::corner_words(const Group& group, int x) {
  RowBits::Corners words;
  for (int corner = 0; corner < 8; ++corner) words[corner] = shifted_word(group, corner, x);
  return words;
}

BlockBits SparseSites::active_cells(const glm::ivec3& origin, const Group& group) const {
  BlockBits active{};
  const bool whole = wholly_in_region(origin);
  for (int x = 0; x < kSize; ++x) {
    active[x] = RowBits::mixed(corner_words(group, x));
    if (!whole && active[x] != 0) active[x] &= region_bits(origin, glm::ivec3(1), x);
  }
  return active;
}

BlockBits SparseSites::crossed_edges(const glm::ivec3& origin, const Group& group, int direction) const {
  BlockBits crossed{};
  const bool whole = wholly_in_region(origin);
  for (int x = 0; x < kSize; ++x) {
    crossed[x] = (*group[0])[x] ^ shifted_word(group, direction, x);
    if (!whole && crossed[x] != 0) crossed[x] &= region_bits(origin, direction_step(direction), x);
  }
  return crossed;
}

void SparseSites::list_sites() {
  const std::vector<glm::ivec3> unstored = unstored_places(samples_, lookup_, rule_, field_.scale);
  std::vector<glm::ivec3> places;
  places.reserve(samples_.blocks.size() + unstored.size());
  for (const SparseBlock& block : samples_.blocks) places.push_back(block.origin);
  places.insert(places.end(), unstored.begin(), unstored.end());
  std::vector<std::uint8_t> passed(places.size());
  for_each("finding crossed blocks", places.size(), [&](std::size_t p) {
    const Group group = group_bits(places[p]);
    for (int direction = 1; direction < 8 && passed[p] == 0; ++direction) {
      const BlockBits crossed = crossed_edges(places[p], group, direction);
      passed[p] = std::ranges::any_of(crossed, [](std::uint64_t word) { return word != 0; }) ? 1 : 0;
    }
  });
  for (std::size_t p = 0; p < places.size(); ++p) {
    if (passed[p] == 0) continue;
    sites_.push_back(places[p]);
    stored_sites_ += p < samples_.blocks.size() ? 1 : 0;
  }
  site_index_ = OriginIndex(sites_.size());
  for (std::size_t s = 0; s < sites_.size(); ++s) site_index_.insert(sites_[s], static_cast<std::int32_t>(s));
}

}  // namespace isoextract
