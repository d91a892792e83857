#include "field/surface_estimate.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <optional>
#include <span>
#include <variant>

#include "base/parallel.hpp"
#include "field/detail/sample_passes.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {
namespace {

bool is_inside(const ScalarField& field, double iso, double stored) {
  const double value = field.scale(stored);
  return field.kind == FieldKind::level_set ? value < iso : value > iso;
}

template <class T>
std::uint64_t count_crossings(std::span<const T> row, const ScalarField& field, double iso) {
  std::uint64_t crossings = 0;
  bool previous = is_inside(field, iso, static_cast<double>(row.front()));
  for (const T stored : row.subspan(1)) {
    const bool inside = is_inside(field, iso, static_cast<double>(stored));
    crossings += inside != previous ? 1 : 0;
    previous = inside;
  }
  return crossings;
}

// One bit per sample of a block: bit y << 3 | z of word x.
using BlockBits = std::array<std::uint64_t, 8>;
constexpr std::uint64_t kFirstAlongY = 0xFF;
constexpr std::uint64_t kFirstAlongZ = 0x0101010101010101ULL;

// Returns the samples that are not on the background's side of the surface.
template <class T>
BlockBits off_background_side(std::span<const T> values, const ScalarField& field, double iso, bool background) {
  BlockBits bits{};
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (is_inside(field, iso, static_cast<double>(values[v])) != background)
      bits[v >> 6] |= std::uint64_t{1} << (v & 63);
  }
  return bits;
}

// Counts the edges within the block, along each axis, whose ends are on different sides.
std::uint64_t count_crossings(const BlockBits& bits) {
  int crossings = 0;
  for (std::size_t x = 0; x < bits.size(); ++x) {
    if (x > 0) crossings += std::popcount(bits[x] ^ bits[x - 1]);
    crossings += std::popcount((bits[x] ^ bits[x] << 8U) & ~kFirstAlongY);
    crossings += std::popcount((bits[x] ^ bits[x] << 1U) & ~kFirstAlongZ);
  }
  return static_cast<std::uint64_t>(crossings);
}

// Counts the edges within `box` that lead from a sample of the row to the next sample along an axis and that the
// surface crosses.
template <class T>
std::uint64_t count_from_row(const ScalarField& field, const DenseSamples& dense, const IndexBox& box, double iso,
                             int j, int k) {
  const glm::i64vec3 dims(dense.dims);
  const auto* row = static_cast<const T*>(dense.data) + dims.x * (j + dims.y * k);
  const auto inside = [&](const T* sample) { return is_inside(field, iso, static_cast<double>(*sample)); };
  std::uint64_t crossings = 0;
  for (int i = box.min.x; i <= box.max.x; ++i) {
    const bool here = inside(row + i);
    crossings += i < box.max.x && inside(row + i + 1) != here ? 1 : 0;
    crossings += j < box.max.y && inside(row + i + dims.x) != here ? 1 : 0;
    crossings += k < box.max.z && inside(row + i + dims.x * dims.y) != here ? 1 : 0;
  }
  return crossings;
}

// Counts the crossed edges within the blocks of sparse samples.
std::uint64_t count_in_blocks(const ScalarField& field, double iso) {
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    return reduce_stored<T>(
        field.samples, std::uint64_t{0},
        [&](std::uint64_t& partial, std::span<const T> block) {
          partial += count_crossings(off_background_side(block, field, iso, false));
        },
        std::plus<>{}, nullptr);
  });
}

// Counts of the grid edges and places that the surface crosses in a sparse field.
struct SurfaceCrossings {
  std::uint64_t edges = 0;   // grid edges
  std::uint64_t places = 0;  // block-sized places

  SurfaceCrossings& operator+=(const SurfaceCrossings& more) {
    edges += more.edges;
    places += more.places;
    return *this;
  }
};

// Finds what a place stores, as SparseLookup does: slower, but with at most 64 bytes for each block and tile, which
// need no reservation beside the samples.
class StoredPlaces {
 public:
  explicit StoredPlaces(const SparseSamples& samples)
      : samples_(samples), blocks_(samples.blocks.size()), tiles_(samples.tiles, SparseBlock::kSize) {
    for (std::size_t b = 0; b < samples.blocks.size(); ++b) {
      blocks_.insert(samples.blocks[b].origin, static_cast<std::int32_t>(b));
    }
  }

  // Returns the same as SparseLookup::place().
  [[nodiscard]] std::int32_t place(const glm::ivec3& origin) const {
    if (const std::int32_t block = blocks_.find(origin); block >= 0) return block;
    const std::int32_t tile = tiles_.find(origin);
    return tile >= 0 ? SparseLookup::place_of_tile(static_cast<std::size_t>(tile)) : SparseLookup::kBackground;
  }
  // Returns the value of a tile from its place().
  [[nodiscard]] double tile_value(std::int32_t place) const {
    return samples_.tiles[SparseLookup::tile_of(place)].value;
  }

 private:
  const SparseSamples& samples_;
  OriginIndex blocks_;
  TileIndex tiles_;
};

// Returns the first or last plane of samples in a block along `axis`.
BlockBits face_of_block(int axis, bool first) {
  BlockBits face{};
  const unsigned place = first ? 0 : SparseBlock::kSize - 1;
  for (std::size_t x = 0; x < face.size(); ++x) {
    if (axis == 0) face[x] = x == place ? ~std::uint64_t{0} : 0;
    if (axis == 1) face[x] = kFirstAlongY << (SparseBlock::kSize * place);
    if (axis == 2) face[x] = kFirstAlongZ << place;
  }
  return face;
}

std::uint64_t count_bits(const BlockBits& bits, const BlockBits& mask) {
  int count = 0;
  for (std::size_t x = 0; x < bits.size(); ++x) count += std::popcount(bits[x] & mask[x]);
  return static_cast<std::uint64_t>(count);
}

// Returns the index in a block's values of sample (u, v) in the first or last plane along `axis`.
std::size_t face_offset(int axis, bool first, int u, int v) {
  glm::ivec3 p(first ? 0 : SparseBlock::kSize - 1);
  p[(axis + 1) % 3] = u;
  p[(axis + 2) % 3] = v;
  return static_cast<std::size_t>(block_offset(p));
}

template <class T>
class CrossingCounter {
 public:
  CrossingCounter(const ScalarField& field, const SparseSamples& samples, double iso)
      : field_(field),
        samples_(samples),
        iso_(iso),
        background_(is_inside(field, iso, samples.background)),
        stored_(samples) {}

  [[nodiscard]] SurfaceCrossings count() const {
    const auto sum = [](SurfaceCrossings a, const SurfaceCrossings& b) { return a += b; };
    SurfaceCrossings passed = reduce_ranges(
        samples_.tiles.size(), 16, SurfaceCrossings{},
        [&](std::size_t begin, std::size_t end, SurfaceCrossings part) {
          for (std::size_t t = begin; t != end; ++t) part += of_tile(samples_.tiles[t]);
          return part;
        },
        sum);
    return passed += reduce_ranges(
               samples_.blocks.size(), 64, SurfaceCrossings{},
               [&](std::size_t begin, std::size_t end, SurfaceCrossings part) {
                 for (std::size_t b = begin; b != end; ++b) part += count_block(samples_.blocks[b]);
                 return part;
               },
               sum);
  }

 private:
  // Returns the samples of a block that are not on the side `inside`.
  [[nodiscard]] BlockBits off_side(std::int32_t block, bool inside) const {
    const auto* values = static_cast<const T*>(samples_.blocks[static_cast<std::size_t>(block)].values);
    return off_background_side(std::span(values, kBlockSamples), field_, iso_, inside);
  }

  // Counts edges within the block, to the following blocks, and to the background; of_tile() counts edges to tiles.
  // Counts as places the block, and each place before it without a block whose cells reach samples off the background's
  // side. If all samples are off that side, the block counts only if a following place has no block.
  [[nodiscard]] SurfaceCrossings count_block(const SparseBlock& block) const {
    const BlockBits off =
        off_background_side(std::span(static_cast<const T*>(block.values), kBlockSamples), field_, iso_, background_);
    SurfaceCrossings passed{count_crossings(off), 0};
    for (int axis = 0; axis < 3; ++axis) passed.edges += edges_along(block, off, axis);
    if (std::ranges::all_of(off, [](std::uint64_t word) { return word == 0; })) return passed;
    bool passes = std::ranges::any_of(off, [](std::uint64_t word) { return ~word != 0; });
    for (int c = 1; c < 8; ++c) {
      const glm::ivec3 away = SparseBlock::kSize * glm::ivec3(c & 1, c >> 1 & 1, c >> 2);
      passes = passes || stored_.place(block.origin + away) < 0;
      std::uint64_t facing = 0;
      for (std::size_t x = 0; x < ((c & 1) != 0 ? 1U : off.size()); ++x) facing |= off[x];
      if ((c & 2) != 0) facing &= kFirstAlongY;
      if ((c & 4) != 0) facing &= kFirstAlongZ;
      if (facing != 0 && stored_.place(block.origin - away) < 0) ++passed.places;
    }
    passed.places += passes ? 1 : 0;
    return passed;
  }

  // `off` holds the block's samples off the background's side.
  [[nodiscard]] std::uint64_t edges_along(const SparseBlock& block, const BlockBits& off, int axis) const {
    glm::ivec3 away(0);
    away[axis] = SparseBlock::kSize;
    std::uint64_t edges = 0;
    if (stored_.place(block.origin - away) == SparseLookup::kBackground) {
      edges += count_bits(off, face_of_block(axis, true));
    }
    const std::int32_t after = stored_.place(block.origin + away);
    if (after == SparseLookup::kBackground) edges += count_bits(off, face_of_block(axis, false));
    if (after >= 0) edges += edges_between(off, after, axis);
    return edges;
  }

  // Counts edges from a block, given its samples off the background's side, to the block after it. Reads only the two
  // planes that face each other.
  [[nodiscard]] std::uint64_t edges_between(const BlockBits& off, std::int32_t after, int axis) const {
    const auto* beside = static_cast<const T*>(samples_.blocks[static_cast<std::size_t>(after)].values);
    std::uint64_t edges = 0;
    for (int u = 0; u < SparseBlock::kSize; ++u) {
      for (int v = 0; v < SparseBlock::kSize; ++v) {
        const std::size_t last = face_offset(axis, false, u, v);
        const bool is_off = (off[last >> 6] >> (last & 63) & 1) != 0;
        const auto stored = static_cast<double>(beside[face_offset(axis, true, u, v)]);
        const bool other_is_off = is_inside(field_, iso_, stored) != background_;
        edges += is_off != other_is_off ? 1 : 0;
      }
    }
    return edges;
  }

  // Counts the edges at the tile's faces, and the block-sized parts of the faces that the surface passes.
  [[nodiscard]] SurfaceCrossings of_tile(const SparseTile& tile) const {
    constexpr int kSize = SparseBlock::kSize;
    SurfaceCrossings passed;
    for (int axis = 0; axis < 3; ++axis) {
      for (int u = 0; u < tile.size; u += kSize) {
        for (int v = 0; v < tile.size; v += kSize) {
          glm::ivec3 at = tile.origin;
          at[(axis + 1) % 3] += u;
          at[(axis + 2) % 3] += v;
          glm::ivec3 before = at;
          before[axis] -= kSize;
          at[axis] += tile.size;
          for (const bool rising : {false, true}) {
            const std::uint64_t edges = count_edges_to(rising ? at : before, axis, rising, tile.value);
            passed += {edges, edges > 0 ? std::uint64_t{1} : 0};
          }
        }
      }
    }
    return passed;
  }

  // Counts the edges from a block-sized part of a tile's face to the place beside it.
  [[nodiscard]] std::uint64_t count_edges_to(const glm::ivec3& beside, int axis, bool rising, double tile_value) const {
    const bool inside = is_inside(field_, iso_, tile_value);
    const std::int32_t place = stored_.place(beside);
    if (place >= 0) return count_bits(off_side(place, inside), face_of_block(axis, rising));
    const bool is_background = place == SparseLookup::kBackground;
    const bool other = is_background ? background_ : is_inside(field_, iso_, stored_.tile_value(place));
    // Between two tiles only the one that is inside counts.
    return other != inside && (is_background || inside) ? std::uint64_t{SparseBlock::kSize} * SparseBlock::kSize : 0;
  }

  const ScalarField& field_;
  const SparseSamples& samples_;
  double iso_;
  bool background_;
  StoredPlaces stored_;
};

// Returns the samples of `box` that the field has; all of them for nullopt.
IndexBox samples_in(const ScalarField& field, const std::optional<IndexBox>& box) {
  const IndexBox all = field.extents();
  return box ? IndexBox{glm::max(all.min, box->min), glm::min(all.max, box->max)} : all;
}

// Runs look(j, k, part), which adds to `part`, for all rows of samples in `box`. Returns the sum of all parts.
template <class Part, class Look>
Part look_at_rows(const DenseSamples& dense, const IndexBox& box, const Look& look) {
  if (box.empty()) return {};
  const glm::i64vec3 dims(dense.dims);
  const auto rows_y = static_cast<std::size_t>(box.max.y - box.min.y) + 1;
  const auto rows_z = static_cast<std::size_t>(box.max.z - box.min.z) + 1;
  const auto first = [&](std::size_t row) {  // its first sample
    const auto j = static_cast<std::int64_t>(row % rows_y) + box.min.y;
    const auto k = static_cast<std::int64_t>(row / rows_y) + box.min.z;
    return static_cast<std::size_t>(dims.x * (j + dims.y * k));
  };
  return reduce_ranges(
      rows_y * rows_z, 64, Part{},
      [&](std::size_t begin, std::size_t end, Part part) {
        for (std::size_t row = begin; row != end; ++row) {
          look(box.min.y + static_cast<int>(row % rows_y), box.min.z + static_cast<int>(row / rows_y), part);
        }
        dense.leave(first(begin), first(end - 1) + static_cast<std::size_t>(dims.x));
        return part;
      },
      std::plus<>{});
}

// Counts along rows of samples.
struct RowSides {
  std::uint64_t crossings = 0;  // of the surface, along x
  std::uint64_t boundary = 0;   // inside samples on the faces of the box
  bool has_nan = false;

  friend RowSides operator+(const RowSides& a, const RowSides& b) {
    return {a.crossings + b.crossings, a.boundary + b.boundary, a.has_nan || b.has_nan};
  }
};

template <class T>
RowSides look_along_rows(const DenseSamples& dense, const ScalarField& field, double iso, const IndexBox& box) {
  const glm::i64vec3 dims(dense.dims);
  return look_at_rows<RowSides>(dense, box, [&](int j, int k, RowSides& sides) {
    const std::span row(static_cast<const T*>(dense.data) + box.min.x + dims.x * (j + dims.y * k),
                        static_cast<std::size_t>(box.max.x - box.min.x) + 1);
    const auto inside = [&](T stored) { return is_inside(field, iso, static_cast<double>(stored)); };
    sides.crossings += count_crossings(row, field, iso);
    const bool is_on_face = j == box.min.y || j == box.max.y || k == box.min.z || k == box.max.z;
    sides.boundary += is_on_face ? static_cast<std::uint64_t>(std::ranges::count_if(row, inside))
                                 : std::uint64_t{inside(row.front())} + std::uint64_t{inside(row.back())};
    if constexpr (is_floating_sample<T>) {
      sides.has_nan = sides.has_nan || std::ranges::any_of(row, [](T stored) { return stored != stored; });
    }
  });
}

}  // namespace

std::uint64_t min_vertex_count(const ScalarField& field, double iso, const std::optional<IndexBox>& box) {
  const auto* dense = std::get_if<DenseSamples>(&field.samples);
  if (dense == nullptr) return box ? 0 : count_in_blocks(field, iso);
  const IndexBox samples = samples_in(field, box);
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    return look_at_rows<std::uint64_t>(*dense, samples, [&](int j, int k, std::uint64_t& crossings) {
      crossings += count_from_row<T>(field, *dense, samples, iso, j, k);
    });
  });
}

SurfaceEstimate estimate_surface(const ScalarField& field, double iso, const std::optional<IndexBox>& box) {
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) -> SurfaceEstimate {
    if (const auto* dense = std::get_if<DenseSamples>(&field.samples)) {
      const RowSides sides = look_along_rows<T>(*dense, field, iso, samples_in(field, box));
      return {3 * sides.crossings, 0, sides.boundary, sides.has_nan};
    }
    const SurfaceCrossings passed = CrossingCounter<T>(field, std::get<SparseSamples>(field.samples), iso).count();
    return {.vertices = passed.edges, .places = passed.places};
  });
}

}  // namespace isoextract::field
