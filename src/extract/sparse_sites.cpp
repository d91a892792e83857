#include "extract/sparse_sites.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "extract/boundary_cap.hpp"
#include "extract/cell_tables.hpp"
#include "extract/detail/classify_samples.hpp"
#include "extract/mesh_assembly.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

constexpr int kBlockSamples = kBlockSize * kBlockSize * kBlockSize;
constexpr const char* kBrick = "8x8x8 voxels";

}  // namespace

Result<field::IndexBox> sparse_region(const field::ScalarField& field, const field::SparseSamples& samples,
                                      const ExtractOptions& options) {
  const field::IndexBox stored = stored_box(samples);
  if (stored.empty()) return stored;
  if (glm::any(glm::lessThan(stored.min, glm::ivec3(-field::kMaxSparseIndex))) ||
      glm::any(glm::greaterThan(stored.max, glm::ivec3(field::kMaxSparseIndex)))) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected voxel indices from -{} to {} along each axis, found voxels outside",
                            field.source, field::kMaxSparseIndex, field::kMaxSparseIndex));
  }
  field::IndexBox reach{stored.min - 1, stored.max + 1};
  // A background inside fills the region, so the cap must be at the faces of the region, however far out.
  if (options.region && InsideRule{field.kind, options.iso}(field.scale(samples.background))) {
    reach = {glm::ivec3(-field::kMaxSparseIndex), glm::ivec3(field::kMaxSparseIndex)};
  }
  return clip_region(field, reach, options);
}

Extraction empty_sparse_extraction() {
  Extraction nothing;
  nothing.stats.brick = kBrick;
  return nothing;
}

std::optional<field::IndexBox> sparse_cap_box(const field::IndexBox& region, const ExtractOptions& options) {
  return options.region ? std::optional(region) : std::nullopt;
}

SparseSites::SparseSites(const field::ScalarField& field, const field::SparseSamples& samples,
                         const field::IndexBox& region, const ExtractOptions& options, const Context& context)
    : field_(field),
      samples_(samples),
      region_(region),
      options_(options),
      context_(context),
      rule_{field.kind, options.iso},
      stored_number_(visit_sample_type(samples.type, []<class T>(std::type_identity<T>) {
        return +[](const void* values, int offset) {
          return static_cast<double>(static_cast<const T*>(values)[offset]);
        };
      })) {}

Result<void> SparseSites::compare(ExtractStats& stats) {
  stats.brick = kBrick;
  stats.bricks = samples_.blocks.size();
  std::vector<glm::ivec3> nodes = field::SparseLookup::node_origins(samples_);
  samples_memory_ = TRY(context_.reserve(
      nodes.size() * sizeof(field::SparseLookup::Node) + samples_.blocks.size() * sizeof(BlockBits), finding_text()));
  const Stopwatch watch;
  lookup_.emplace(samples_, std::move(nodes));
  visit_sample_type(samples_.type, [&]<class T>(std::type_identity<T>) { classify<T>(stats); });
  if (stats.nan_samples != 0 && options_.nan == NanPolicy::error) {
    return nan_error(field_, stats.nan_samples, first_nan());
  }
  has_holes_ = stats.nan_samples != 0 && options_.nan == NanPolicy::hole;
  stats.classify = watch.elapsed();
  return context_.check();
}

Result<void> SparseSites::find(ExtractStats& stats) {
  TRY(compare(stats));
  const Stopwatch watch;
  const auto skins = context_.reserve(tile_skin_bytes(samples_, rule_, field_.scale),
                                      finding_text());  // held until the sites are listed
  if (!skins) return tl::unexpected(skins.error());
  TRY(list_sites());
  stats.bricks_visited = stored_sites_;
  stats.places_visited = sites_.size() - stored_sites_;
  stats.classify += watch.elapsed();
  return {};
}

std::string SparseSites::finding_text() const {
  return fmt::format("{}: the search for unstored neighbors of its {} blocks and {} tiles", field_.source,
                     samples_.blocks.size(), samples_.tiles.size());
}

template <class T>
void SparseSites::classify(ExtractStats& stats) {
  const std::size_t blocks = samples_.blocks.size();
  bits_ = Buffer<BlockBits>(blocks);
  const auto threshold = find_inside_threshold<T>(rule_, field_.scale);
  const auto limit = threshold.value_or(InsideThreshold<T>{});
  std::atomic<std::uint64_t> nan{0};
  for_each("classifying blocks", blocks, [&](std::size_t b) {
    const auto* values = static_cast<const T*>(samples_.blocks[b].values);
    std::array<std::uint64_t, kBlockSize + 1> bits;  // classify_samples() may change one word after the block
    const std::uint64_t block_nan = classify_samples(values, kBlockSamples, limit, bits.data());
    if (!threshold) bits.fill(0);
    std::copy_n(bits.begin(), kBlockSize, bits_[b].begin());
    if (block_nan != 0 && touches_region(samples_.blocks[b].origin, kBlockSize)) {
      nan.fetch_add(block_nan, std::memory_order_relaxed);
    }
  });
  sides_.tiles_inside.resize(samples_.tiles.size());
  for_each("classifying tiles", sides_.tiles_inside.size(),
           [&](std::size_t t) { sides_.tiles_inside[t] = rule_(field_.scale(samples_.tiles[t].value)) ? 1 : 0; });
  sides_.background_inside = rule_(field_.scale(samples_.background));
  stats.samples_classified = blocks * kBlockSamples;
  stats.nan_samples = nan.load();
  for (const field::SparseTile& tile : samples_.tiles) {
    if (!std::isnan(tile.value) || !touches_region(tile.origin, tile.size)) continue;
    const auto side = static_cast<std::uint64_t>(tile.size);
    stats.nan_samples += side * side * side;
  }
  stats.nan_samples += std::isnan(samples_.background) ? 1 : 0;
}

// Only blocks and tiles that touch the region are searched for NaN.
bool SparseSites::touches_region(const glm::ivec3& origin, int size) const {
  return glm::all(glm::lessThanEqual(origin, region_.max)) &&
         glm::all(glm::greaterThanEqual(origin + (size - 1), region_.min));
}

glm::ivec3 SparseSites::first_nan() const {
  for (const field::SparseBlock& block : samples_.blocks) {
    if (!touches_region(block.origin, kBlockSize)) continue;
    for (int v = 0; v < kBlockSamples; ++v) {
      if (std::isnan(stored_number_(block.values, v))) return block.origin + glm::ivec3(v >> 6, v >> 3 & 7, v & 7);
    }
  }
  for (const field::SparseTile& tile : samples_.tiles) {
    if (std::isnan(tile.value) && touches_region(tile.origin, tile.size)) return tile.origin;
  }
  return stored_box(samples_).max + 1;  // the background is NaN: name a sample outside the stored box
}

// Returns the inside bits of a place (numbered by SparseLookup).
const BlockBits* SparseSites::bits_of(std::int32_t place) const {
  static constexpr BlockBits kOutside{};
  static constexpr BlockBits kInside = [] {
    BlockBits bits{};
    bits.fill(~std::uint64_t{0});
    return bits;
  }();
  if (place >= 0) return &bits_[static_cast<std::size_t>(place)];
  return sides_.inside(place) ? &kInside : &kOutside;
}

SitePlanes SparseSites::planes_of(const field::SparseLookup::Group& group) const {
  std::array<const BlockBits*, 8> bits;
  for (std::size_t n = 0; n < 8; ++n) bits[n] = bits_of(group[n]);
  return site_planes(bits);
}

double SparseSites::value(const glm::ivec3& p) const {
  const glm::ivec3 origin = field::block_origin(p);
  const std::int32_t block = lookup_->block(origin);
  if (block < 0) return field_.scale(lookup_->constant(origin));
  return field_.scale(stored_number_(samples_.blocks[static_cast<std::size_t>(block)].values, field::block_offset(p)));
}

// Returns the samples of word x that are in the region, also when moved by `step`.
std::uint64_t SparseSites::region_bits(const glm::ivec3& origin, const glm::ivec3& step, int x) const {
  const glm::ivec3 low = region_.min - origin;
  const glm::ivec3 high = region_.max - step - origin;
  if (x < low.x || x > high.x) return 0;
  std::uint64_t bits = 0;
  for (int y = std::max(low.y, 0); y <= std::min(high.y, kBlockSize - 1); ++y) {
    for (int z = std::max(low.z, 0); z <= std::min(high.z, kBlockSize - 1); ++z)
      bits |= std::uint64_t{1} << (8 * y + z);
  }
  return bits;
}

bool SparseSites::wholly_in_region(const glm::ivec3& origin) const {
  return glm::all(glm::greaterThanEqual(origin, region_.min)) &&
         glm::all(glm::lessThanEqual(origin + kBlockSize, region_.max));
}

BlockBits SparseSites::active_cells(std::size_t site, const SitePlanes& planes) const {
  const glm::ivec3& origin = sites_[site];
  const bool whole = wholly_in_region(origin);
  BlockBits active;
  std::uint64_t any = 0;  // OR and AND of the bits of the plane before
  std::uint64_t all = 0;
  for (std::size_t x = 0; x < planes.size(); ++x) {
    const auto& [p, y, z, yz] = planes[x];
    const std::uint64_t any_here = p | y | z | yz;
    const std::uint64_t all_here = p & y & z & yz;
    if (x > 0) {
      active[x - 1] = (any | any_here) & ~(all & all_here);
      if (!whole) active[x - 1] &= region_bits(origin, glm::ivec3(1), static_cast<int>(x) - 1);
    }
    any = any_here;
    all = all_here;
  }
  return active;
}

BlockBits SparseSites::crossed_edges_at(const glm::ivec3& origin, const SitePlanes& planes, int direction) const {
  const bool whole = wholly_in_region(origin);
  BlockBits crossed;
  for (int x = 0; x < kBlockSize; ++x) {
    crossed[x] = moved_bits(planes, 0, x) ^ moved_bits(planes, direction, x);
    if (!whole) crossed[x] &= region_bits(origin, direction_step(direction), x);
  }
  return crossed;
}

template <class Found>
bool SparseSites::any_boundary_edge(const Found& found) const {
  for (std::size_t site = 0; site < sites_.size(); ++site) {
    const glm::ivec3& origin = sites_[site];
    const bool within = glm::all(glm::greaterThan(origin, region_.min)) &&
                        glm::all(glm::lessThan(origin + (kBlockSize - 1), region_.max));
    if (within) continue;
    const SitePlanes planes = planes_of(groups_[site]);
    bool any = false;
    for (int axis = 0; axis < 3; ++axis) {
      const BlockBits crossed = crossed_edges_at(origin, planes, 1 << axis);
      for (int x = 0; x < kBlockSize; ++x) {
        for_each_bit(crossed[x], [&](int bit) {
          const glm::ivec3 p = origin + glm::ivec3(x, bit >> 3, bit & 7);
          bool on_face = false;
          for (int across = 0; across < 3; ++across) {  // an edge that only ends in a face does not lie in it
            on_face =
                on_face || (across != axis && (p[across] == region_.min[across] || p[across] == region_.max[across]));
          }
          any = any || (on_face && found(p, axis));
        });
      }
    }
    if (any) return true;
  }
  return false;
}

BoundarySides SparseSites::boundary_sides() const {
  if (!options_.region) return {};
  if (any_boundary_edge([](const glm::ivec3&, int) { return true; })) return {true, true};
  const bool all_inside = inside(region_.min);
  return {all_inside, !all_inside};
}

bool SparseSites::draws_at_boundary() const {
  return any_boundary_edge([this](const glm::ivec3& p, int axis) {
    return draws_beside_edge(region_, p, axis, [this](const glm::ivec3& q) { return std::isnan(value(q)); });
  });
}

bool SparseSites::owns_crossed_edge(const glm::ivec3& origin, const field::SparseLookup::Group& group) const {
  // Decides most places by their own samples, or because all samples around them are on one side.
  const auto sides = [](const BlockBits& bits) {
    std::uint64_t any = 0;
    std::uint64_t all = ~std::uint64_t{0};
    for (const std::uint64_t word : bits) {
      any |= word;
      all &= word;
    }
    return (any != 0 ? 1 : 0) | (~all != 0 ? 2 : 0);
  };
  const int own = sides(*bits_of(group[0]));
  if (own == 3 && wholly_in_region(origin)) return true;
  int around = own;
  for (std::size_t n = 1; n < group.size(); ++n) around |= sides(*bits_of(group[n]));
  if (around != 3) return false;
  const SitePlanes planes = planes_of(group);
  for (int direction = 1; direction < 8; ++direction) {
    const BlockBits crossed = crossed_edges_at(origin, planes, direction);
    if (std::ranges::any_of(crossed, [](std::uint64_t word) { return word != 0; })) return true;
  }
  return false;
}

Result<void> SparseSites::list_sites() {
  const std::size_t blocks = samples_.blocks.size();
  auto listing = TRY(
      context_.reserve(unstored_places_bytes(samples_, lookup_->nodes().size()),
                       fmt::format("{}: the list of the unstored neighbors of its {} blocks", field_.source, blocks)));
  const std::vector<glm::ivec3> unstored = find_unstored_places(samples_, *lookup_, sides_);
  listing.release();
  const auto place = [&](std::size_t p) { return p < blocks ? samples_.blocks[p].origin : unstored[p - blocks]; };
  const auto looking = TRY(context_.reserve(
      (blocks + unstored.size()) * (sizeof(field::SparseLookup::Group) + sizeof(glm::ivec3) + 1),
      fmt::format("{}: the search of {} blocks for the surface", field_.source, blocks + unstored.size())));
  std::vector<field::SparseLookup::Group> groups(blocks + unstored.size());
  std::vector<std::uint8_t> passed(groups.size());
  for_each("finding crossed blocks", groups.size(), [&](std::size_t p) {
    groups[p] = lookup_->group(place(p));
    passed[p] = owns_crossed_edge(place(p), groups[p]) ? 1 : 0;
  });
  const auto count = static_cast<std::size_t>(std::ranges::count(passed, std::uint8_t{1}));
  constexpr std::uint64_t kBytesASite = 128;  // origin, group and share of the index
  sites_memory_ =
      TRY(context_.reserve(count * kBytesASite, fmt::format("{}: the table of the {} blocks that the surface crosses",
                                                            field_.source, count)));
  sites_.reserve(count);
  groups_.reserve(count);
  site_index_ = field::OriginIndex(count);
  for (std::size_t p = 0; p < groups.size(); ++p) {
    if (passed[p] == 0) continue;
    site_index_.insert(place(p), static_cast<std::int32_t>(sites_.size()));
    sites_.push_back(place(p));
    groups_.push_back(groups[p]);
    stored_sites_ += p < blocks ? 1 : 0;
  }
  return {};
}

}  // namespace isoextract::extract
