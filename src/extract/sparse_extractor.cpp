#include "extract/sparse_extractor.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "base/stopwatch.hpp"
#include "extract/asymptotic_decider.hpp"
#include "extract/cell_output.hpp"
#include "extract/cell_streams.hpp"
#include "extract/mesh_assembly.hpp"
#include "extract/row_walk.hpp"
#include "extract/sparse_blocks.hpp"
#include "mesh/vertex_fans.hpp"

namespace isoextract {
namespace {

constexpr int kSize = SparseBlock::kSize;
constexpr int kBlockSamples = kSize * kSize * kSize;
constexpr std::size_t kGrain = 64;

// The values around one place: the block-size places up to one away along each axis.
template <class T>
class Neighbourhood {
 public:
  // `lowest` is -1 if places before this one are needed too (for gradients), otherwise 0.
  Neighbourhood(const SparseSamples& samples, const SparseLookup& lookup, const glm::ivec3& origin, int lowest)
      : origin_(origin) {
    for (int z = lowest; z <= 1; ++z) {
      for (int y = lowest; y <= 1; ++y) {
        for (int x = lowest; x <= 1; ++x) {
          Place& place = places_[slot(x, y, z)];
          const glm::ivec3 at = origin + kSize * glm::ivec3(x, y, z);
          const std::int32_t block = lookup.block(at);
          if (block >= 0) {
            place.values = static_cast<const T*>(samples.blocks[block].values);
          } else {
            place.constant = lookup.constant(at);
          }
        }
      }
    }
  }

  // The stored number at a sample within the places asked for.
  [[nodiscard]] double operator()(const glm::ivec3& p) const {
    const glm::ivec3 away = (p - origin_) >> 3;
    const Place& place = places_[slot(away.x, away.y, away.z)];
    return place.values != nullptr ? static_cast<double>(place.values[block_offset(p)]) : place.constant;
  }

 private:
  struct Place {
    const T* values = nullptr;
    double constant = 0;
  };
  static int slot(int x, int y, int z) { return (x + 1) + 3 * (y + 1) + 9 * (z + 1); }

  glm::ivec3 origin_;
  std::array<Place, 27> places_;
};

template <class T, int kDirections>
class SparseExtraction {
 public:
  SparseExtraction(const ScalarField& field, const SparseSamples& samples, const IndexBox& region,
                   const ExtractOptions& options)
      : field_(field),
        samples_(samples),
        region_(region),
        options_(options),
        rule_{field.kind, options.iso},
        lookup_(samples),
        table_(case_table(options.method)),
        placement_(options.output_from_index, stored_box(samples), field.kind, field.scale) {}

  Result<Extraction> run() {
    Extraction result;
    result.mesh.origin = placement_.origin();
    result.stats.brick = "8x8x8 voxels";
    result.stats.bricks = samples_.blocks.size();

    if (auto fits = check_placement(field_, placement_); !fits) return tl::unexpected(fits.error());
    if (auto fits = check_memory(tile_skin_bytes(samples_, rule_, field_.scale), options_.limits,
                                 fmt::format("{}: the skins of its {} tiles", field_.source, samples_.tiles.size()));
        !fits) {
      return tl::unexpected(fits.error());
    }
    Stopwatch watch;
    classify(result.stats);
    if (result.stats.nan_samples != 0 && options_.nan == NanPolicy::error) {
      return nan_error(field_, result.stats.nan_samples, first_nan());
    }
    result.stats.classify = watch.elapsed();
    has_holes_ = result.stats.nan_samples != 0 && options_.nan == NanPolicy::hole;

    watch.restart();
    find_sites();
    result.stats.hole_cells = count();
    result.stats.bricks_visited = stored_sites_;
    result.stats.places_visited = sites_.size() - stored_sites_;
    const MeshSizes sizes = place_sites();
    if (auto fits = check_mesh_size(field_, sizes, options_); !fits) return tl::unexpected(fits.error());
    BorderCap cap;
    if (options_.cap && options_.region) {
      if (auto fits = check_cap_size(field_, region_, options_); !fits) return tl::unexpected(fits.error());
      cap = make_border_cap(
          region_, options_.method, static_cast<std::uint32_t>(sizes.vertices),
          [&](const glm::ivec3& p) { return inside(p); },
          [&](const glm::ivec3& p, int direction) { return edge_vertex(p, direction); },
          [&](const glm::ivec3& p) { return rule_.depth(value(p)); },
          [&](const glm::ivec3& p) { return has_holes_ && std::isnan(value(p)); });
      if (auto fits = check_mesh_size(field_, with_cap(sizes, cap), options_); !fits) {
        return tl::unexpected(fits.error());
      }
    }
    result.stats.count = watch.elapsed();

    watch.restart();
    allocate_mesh(result.mesh, sizes, cap, options_);
    emit(result.mesh);
    append_cap(result.mesh, sizes, cap, region_, glm::ivec3(0), placement_);
    if (has_holes_) {
      if (auto done = make_one_vertex_a_fan(result.mesh, options_.limits, field_.source); !done) {
        return tl::unexpected(done.error());
      }
    }
    result.stats.emit = watch.elapsed();
    return result;
  }

 private:
  // ---- classification

  void classify(ExtractStats& stats) {
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
  [[nodiscard]] bool touches_region(const glm::ivec3& origin, int size) const {
    return glm::all(glm::lessThanEqual(origin, region_.max)) &&
           glm::all(glm::greaterThanEqual(origin + (size - 1), region_.min));
  }

  glm::ivec3 first_nan() const {
    for (const SparseBlock& block : samples_.blocks) {
      if (!touches_region(block.origin, kSize)) continue;
      for (int v = 0; v < kBlockSamples; ++v) {
        if (std::isnan(static_cast<double>(static_cast<const T*>(block.values)[v]))) {
          return block.origin + glm::ivec3(v >> 6, v >> 3 & 7, v & 7);
        }
      }
    }
    for (const SparseTile& tile : samples_.tiles) {
      if (std::isnan(tile.value) && touches_region(tile.origin, tile.size)) return tile.origin;
    }
    return stored_box(samples_).max + 1;  // only the background is left
  }

  // The bits of the block-size place at `origin`, stored or not.
  [[nodiscard]] const BlockBits* place_bits(const glm::ivec3& origin) const {
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

  [[nodiscard]] std::array<const BlockBits*, 8> group_bits(const glm::ivec3& origin) const {
    std::array<const BlockBits*, 8> group;
    for (int n = 0; n < 8; ++n) group[n] = place_bits(origin + kSize * direction_step(n));
    return group;
  }

  [[nodiscard]] bool inside(const glm::ivec3& p) const {
    const int offset = block_offset(p);
    return ((*place_bits(block_origin(p)))[offset >> 6] >> (offset & 63) & 1) != 0;
  }

  // ---- sites: the places that the surface passes

  template <class F>
  void for_each(const char* stage, std::size_t count, const F& f) {
    if (options_.progress != nullptr) options_.progress->begin(stage, count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const auto& range) {
      for (std::size_t i = range.begin(); i != range.end(); ++i) f(i);
      if (options_.progress != nullptr) options_.progress->advance(range.size());
    });
  }

  // The samples of word x whose position plus `step` is still in the region.
  [[nodiscard]] std::uint64_t region_bits(const glm::ivec3& origin, const glm::ivec3& step, int x) const {
    const glm::ivec3 low = region_.min - origin;
    const glm::ivec3 high = region_.max - step - origin;
    if (x < low.x || x > high.x) return 0;
    std::uint64_t bits = 0;
    for (int y = std::max(low.y, 0); y <= std::min(high.y, kSize - 1); ++y) {
      for (int z = std::max(low.z, 0); z <= std::min(high.z, kSize - 1); ++z) bits |= std::uint64_t{1} << (8 * y + z);
    }
    return bits;
  }

  [[nodiscard]] bool wholly_in_region(const glm::ivec3& origin) const {
    return glm::all(glm::greaterThanEqual(origin, region_.min)) &&
           glm::all(glm::lessThanEqual(origin + kSize, region_.max));
  }

  // The bits of the eight corners of the cells of word x.
  static RowBits::Corners corner_words(const std::array<const BlockBits*, 8>& group, int x) {
    RowBits::Corners words;
    for (int corner = 0; corner < 8; ++corner) words[corner] = shifted_word(group, corner, x);
    return words;
  }

  // Cells of the place that the surface passes, and that lie in the region.
  [[nodiscard]] BlockBits active_cells(const glm::ivec3& origin, const std::array<const BlockBits*, 8>& group) const {
    BlockBits active{};
    const bool whole = wholly_in_region(origin);
    for (int x = 0; x < kSize; ++x) {
      active[x] = RowBits::mixed(corner_words(group, x));
      if (!whole && active[x] != 0) active[x] &= region_bits(origin, glm::ivec3(1), x);
    }
    return active;
  }

  // Edges of one direction owned by the place's samples that are crossed and lie in the region.
  [[nodiscard]] BlockBits crossed_edges(const glm::ivec3& origin, const std::array<const BlockBits*, 8>& group,
                                        int direction) const {
    BlockBits crossed{};
    const bool whole = wholly_in_region(origin);
    for (int x = 0; x < kSize; ++x) {
      crossed[x] = (*group[0])[x] ^ shifted_word(group, direction, x);
      if (!whole && crossed[x] != 0) crossed[x] &= region_bits(origin, direction_step(direction), x);
    }
    return crossed;
  }

  void find_sites() {
    const std::vector<glm::ivec3> unstored = unstored_places(samples_, lookup_, rule_, field_.scale);
    std::vector<glm::ivec3> places;
    places.reserve(samples_.blocks.size() + unstored.size());
    for (const SparseBlock& block : samples_.blocks) places.push_back(block.origin);
    places.insert(places.end(), unstored.begin(), unstored.end());
    std::vector<std::uint8_t> passed(places.size());
    for_each("finding crossed blocks", places.size(), [&](std::size_t p) {
      const auto group = group_bits(places[p]);
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

  // ---- counting and numbering

  // What one site has of one direction's edges.
  struct SiteEdges {
    BlockBits crossed;
    std::array<std::uint16_t, kSize> before;  // crossed edges in earlier words
    std::uint32_t first;                      // a count at first, then the number of the first vertex
  };

  [[nodiscard]] SiteEdges& edges_of(std::size_t site, int direction_index) {
    return edges_[site * kDirections + static_cast<std::size_t>(direction_index)];
  }
  [[nodiscard]] const SiteEdges& edges_of(std::size_t site, int direction_index) const {
    return edges_[site * kDirections + static_cast<std::size_t>(direction_index)];
  }

  static constexpr int direction_index(int direction) { return isoextract::direction_index<kDirections>(direction); }

  // Returns how many cells NanPolicy::hole leaves out.
  std::uint64_t count() {
    std::atomic<std::uint64_t> hole_cells{0};
    edges_ = Buffer<SiteEdges>(sites_.size() * kDirections);
    triangle_base_ = Buffer<std::uint64_t>(sites_.size());
    for_each("counting", sites_.size(), [&](std::size_t s) {
      const auto group = group_bits(sites_[s]);
      for (const std::uint8_t direction : table_.directions) {
        SiteEdges& edges = edges_of(s, direction_index(direction));
        edges.crossed = crossed_edges(sites_[s], group, direction);
        std::uint16_t total = 0;
        for (int x = 0; x < kSize; ++x) {
          edges.before[x] = total;
          total = static_cast<std::uint16_t>(total + std::popcount(edges.crossed[x]));
        }
        edges.first = total;
      }
      std::uint64_t triangles = 0;
      const std::uint64_t left_out = for_each_active_cell(sites_[s], group, [&](int, int, unsigned v) {
        triangles += static_cast<std::uint64_t>(table_.first[v + 1] - table_.first[v]);
      });
      triangle_base_[s] = triangles;
      if (left_out != 0) hole_cells.fetch_add(left_out, std::memory_order_relaxed);
    });
    return hole_cells.load();
  }

  // f(x, bit, variant). Returns how many cells were left out as holes.
  template <class F>
  std::uint64_t for_each_active_cell(const glm::ivec3& origin, const std::array<const BlockBits*, 8>& group,
                                     const F& f) const {
    std::uint64_t left_out = 0;
    const BlockBits active = active_cells(origin, group);
    for (int x = 0; x < kSize; ++x) {
      if (active[x] == 0) continue;
      const RowBits::Corners corners = corner_words(group, x);
      for_each_bit(active[x], [&](int bit) {
        const glm::ivec3 p = origin + glm::ivec3(x, bit >> 3, bit & 7);
        if (has_holes_ && touches_nan(p)) {
          ++left_out;
          return;
        }
        f(x, bit, variant(RowBits::cell_case(corners, bit), p));
      });
    }
    return left_out;
  }

  // Whether a corner of the cell at `p` is not a number.
  [[nodiscard]] bool touches_nan(const glm::ivec3& p) const {
    for (int corner = 0; corner < 8; ++corner) {
      if (std::isnan(value(p + direction_step(corner)))) return true;
    }
    return false;
  }

  // The value of any sample: for the few that are looked at one by one.
  [[nodiscard]] double value(const glm::ivec3& p) const {
    const glm::ivec3 origin = block_origin(p);
    const std::int32_t block = lookup_.block(origin);
    if (block < 0) return field_.scale(lookup_.constant(origin));
    const auto* values = static_cast<const T*>(samples_.blocks[static_cast<std::size_t>(block)].values);
    return field_.scale(static_cast<double>(values[block_offset(p)]));
  }

  // What the cell at `p` draws.
  [[nodiscard]] unsigned variant(unsigned cell_case, const glm::ivec3& p) const {
    return cell_variant(table_, cell_case, rule_, [&](int corner) { return value(p + direction_step(corner)); });
  }

  MeshSizes place_sites() {
    MeshSizes sizes;
    for (SiteEdges& edges : edges_) {
      sizes.vertices += std::exchange(edges.first, static_cast<std::uint32_t>(sizes.vertices));
    }
    for (std::uint64_t& base : triangle_base_) sizes.triangles += std::exchange(base, sizes.triangles);
    return sizes;
  }

  [[nodiscard]] std::uint32_t vertex_at(std::size_t site, int direction_index, int offset) const {
    const SiteEdges& edges = edges_of(site, direction_index);
    const int x = offset >> 6;
    const std::uint64_t below = edges.crossed[x] & ((std::uint64_t{1} << (offset & 63)) - 1);
    return edges.first + edges.before[x] + static_cast<std::uint32_t>(std::popcount(below));
  }

  [[nodiscard]] std::uint32_t edge_vertex(const glm::ivec3& p, int direction) const {
    const auto site = static_cast<std::size_t>(site_index_.find(block_origin(p)));
    return vertex_at(site, direction_index(direction), block_offset(p));
  }

  // ---- output

  void emit(Mesh& mesh) {
    for_each("extracting", sites_.size(), [&](std::size_t s) {
      emit_vertices(mesh, s);
      emit_triangles(mesh, s);
    });
  }

  void emit_vertices(Mesh& mesh, std::size_t s) const {
    const Neighbourhood<T> stored(samples_, lookup_, sites_[s], options_.smooth_normals ? -1 : 0);
    for (const std::uint8_t direction : table_.directions) {
      const SiteEdges& edges = edges_of(s, direction_index(direction));
      std::size_t number = edges.first;
      for (int x = 0; x < kSize; ++x) {
        for_each_bit(edges.crossed[x], [&](int bit) {
          emit_vertex(mesh, number++, stored, sites_[s] + glm::ivec3(x, bit >> 3, bit & 7), direction_step(direction));
        });
      }
    }
  }

  void emit_vertex(Mesh& mesh, std::size_t number, const Neighbourhood<T>& stored, const glm::ivec3& p,
                   const glm::ivec3& step) const {
    const auto gradient = [&](const glm::ivec3& q) {
      const auto difference = [&](const glm::ivec3& axis) { return (stored(q + axis) - stored(q - axis)) / 2; };
      return glm::dvec3(difference({1, 0, 0}), difference({0, 1, 0}), difference({0, 0, 1}));
    };
    write_vertex(
        mesh, number, placement_, rule_, p, step, [&](const glm::ivec3& q) { return field_.scale(stored(q)); },
        gradient);
  }

  void emit_triangles(Mesh& mesh, std::size_t s) const {
    const glm::ivec3 origin = sites_[s];
    std::array<std::int32_t, 8> near;  // the sites that own the edges of this site's cells
    for (int n = 0; n < 8; ++n) near[n] = site_index_.find(origin + kSize * direction_step(n));
    glm::uvec3* out = mesh.triangles.data() + triangle_base_[s];
    for_each_active_cell(origin, group_bits(origin), [&](int x, int bit, unsigned v) {
      const auto vertex = [&](std::uint8_t edge) {
        const CellEdge& e = table_.edges[edge];
        const glm::ivec3 p = glm::ivec3(x, bit >> 3, bit & 7) + direction_step(e.corner);
        const int n = p.x >> 3 | p.y >> 3 << 1 | p.z >> 3 << 2;
        return vertex_at(static_cast<std::size_t>(near[n]), direction_index(e.direction), block_offset(p));
      };
      out = write_cell(table_, v, placement_.mirrored(), vertex, out);
    });
  }

  const ScalarField& field_;
  const SparseSamples& samples_;
  IndexBox region_;
  const ExtractOptions& options_;
  InsideRule rule_;
  SparseLookup lookup_;
  const CaseTable& table_;
  Placement placement_;
  Buffer<BlockBits> bits_;         // of the stored blocks
  std::vector<glm::ivec3> sites_;  // stored blocks first, then places without one; each part sorted
  std::uint64_t stored_sites_ = 0;
  OriginIndex site_index_;
  Buffer<SiteEdges> edges_;              // per site and direction
  Buffer<std::uint64_t> triangle_base_;  // per site: first a count, then the first triangle
  bool has_holes_ = false;               // some samples are NaN, and NanPolicy::hole
};

}  // namespace

Result<Extraction> extract_sparse(const ScalarField& field, const SparseSamples& samples,
                                  const ExtractOptions& options) {
  const IndexBox stored = stored_box(samples);
  if (stored.empty()) {
    Extraction nothing;
    nothing.stats.brick = "8x8x8 voxels";
    return nothing;
  }
  if (glm::any(glm::lessThan(stored.min, glm::ivec3(-kMaxSparseIndex))) ||
      glm::any(glm::greaterThan(stored.max, glm::ivec3(kMaxSparseIndex)))) {
    return fail(ErrorKind::input,
                fmt::format("{}: voxels lie farther than {} from index 0", field.source, kMaxSparseIndex));
  }
  // One sample of background all round closes every surface. Where the background itself is inside, a region's cap
  // must stand where the region ends.
  IndexBox reach{stored.min - 1, stored.max + 1};
  if (options.region && InsideRule{field.kind, options.iso}(field.scale(samples.background))) {
    reach = {glm::ivec3(-kMaxSparseIndex), glm::ivec3(kMaxSparseIndex)};
  }
  const auto region = clip_region(field, reach, options);
  if (!region) return tl::unexpected(region.error());
  return visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) -> Result<Extraction> {
    if (options.method == Method::mc) return SparseExtraction<T, 3>(field, samples, *region, options).run();
    return SparseExtraction<T, 7>(field, samples, *region, options).run();
  });
}

}  // namespace isoextract
