#include "field/surface_estimate.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <span>
#include <tuple>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "field/detail/sample_passes.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {
namespace {

constexpr std::size_t kBlockSamples = std::size_t{SparseBlock::kSize} * SparseBlock::kSize * SparseBlock::kSize;

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

// One bit a sample of a block: bit y << 3 | z of word x.
using BlockBits = std::array<std::uint64_t, 8>;
constexpr std::uint64_t kFirstAlongY = 0xFF;
constexpr std::uint64_t kFirstAlongZ = 0x0101010101010101ULL;

// The samples that are not on the background's side.
template <class T>
BlockBits off_background(std::span<const T> values, const ScalarField& field, double iso, bool background) {
  BlockBits bits{};
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (is_inside(field, iso, static_cast<double>(values[v])) != background)
      bits[v >> 6] |= std::uint64_t{1} << (v & 63);
  }
  return bits;
}

// Edges between samples of the block, along each axis, whose ends are on different sides.
std::uint64_t count_crossings(const BlockBits& bits) {
  int crossings = 0;
  for (std::size_t x = 0; x < bits.size(); ++x) {
    if (x > 0) crossings += std::popcount(bits[x] ^ bits[x - 1]);
    crossings += std::popcount((bits[x] ^ bits[x] << 8U) & ~kFirstAlongY);
    crossings += std::popcount((bits[x] ^ bits[x] << 1U) & ~kFirstAlongZ);
  }
  return static_cast<std::uint64_t>(crossings);
}

bool is_stored(const SparseSamples& samples, const glm::ivec3& origin) {
  const auto order = [](const glm::ivec3& p) { return std::tuple(p.x, p.y, p.z); };
  return std::ranges::binary_search(samples.blocks, order(origin), {},
                                    [&](const SparseBlock& block) { return order(block.origin); });
}

// What a block adds: itself, and the places before it that its samples at their side have an edge to. Where it is
// wholly off the background's side, the surface passes it only if nothing is stored beside it.
template <class T>
std::uint64_t places_at(const SparseBlock& block, const SparseSamples& samples, const ScalarField& field, double iso,
                        bool background) {
  const BlockBits off =
      off_background(std::span(static_cast<const T*>(block.values), kBlockSamples), field, iso, background);
  if (std::ranges::all_of(off, [](std::uint64_t word) { return word == 0; })) return 0;
  bool passes = std::ranges::any_of(off, [](std::uint64_t word) { return ~word != 0; });
  std::uint64_t places = 0;
  for (int c = 1; c < 8; ++c) {
    const glm::ivec3 away = SparseBlock::kSize * glm::ivec3(c & 1, c >> 1 & 1, c >> 2);
    passes = passes || !is_stored(samples, block.origin + away);
    std::uint64_t facing = 0;
    for (std::size_t x = 0; x < ((c & 1) != 0 ? 1U : off.size()); ++x) facing |= off[x];
    if ((c & 2) != 0) facing &= kFirstAlongY;
    if ((c & 4) != 0) facing &= kFirstAlongZ;
    if (facing != 0 && !is_stored(samples, block.origin - away)) ++places;
  }
  return places + (passes ? 1 : 0);
}

// Edges from the samples of one row in rising directions whose ends are on different sides. `box` is of dense samples.
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

// Of sparse samples: edges within their blocks.
std::uint64_t count_in_blocks(const ScalarField& field, double iso) {
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    return reduce_stored<T>(
        field.samples, std::uint64_t{0},
        [&](std::uint64_t& partial, std::span<const T> block) {
          partial += count_crossings(off_background(block, field, iso, false));
        },
        std::plus<>{}, nullptr);
  });
}

// Counts what the surface passes at the faces of tiles.
struct TileFaces {
  std::uint64_t crossings = 0;
  std::uint64_t places = 0;  // faces of block size that it passes
};

// The samples of a block that lie at a face: those whose place along `axis` is 0, or 7.
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

template <class T>
TileFaces faces_of_tile(const SparseTile& tile, const SparseSamples& samples, const SparseLookup& lookup,
                        const ScalarField& field, double iso) {
  constexpr int kSize = SparseBlock::kSize;
  TileFaces faces;
  const bool inside = is_inside(field, iso, tile.value);
  const auto pass_face = [&](const glm::ivec3& beside, int axis, bool rising) {
    const std::int32_t place = lookup.place(beside);
    std::uint64_t crossings = 0;
    if (place >= 0) {
      const BlockBits off = off_background(
          std::span(static_cast<const T*>(samples.blocks[static_cast<std::size_t>(place)].values), kBlockSamples),
          field, iso, inside);
      const BlockBits at = face_of_block(axis, rising);
      for (std::size_t x = 0; x < off.size(); ++x) crossings += std::popcount(off[x] & at[x]);
    } else if (is_inside(field, iso, lookup.constant_of(place)) != inside) {
      // Between two tiles only the one that is inside counts crossings.
      if (place == SparseLookup::kBackground || inside) crossings = std::uint64_t{kSize} * kSize;
    }
    faces.crossings += crossings;
    faces.places += crossings > 0 ? 1 : 0;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (int u = 0; u < tile.size; u += kSize) {
      for (int v = 0; v < tile.size; v += kSize) {
        glm::ivec3 at = tile.origin;
        at[(axis + 1) % 3] += u;
        at[(axis + 2) % 3] += v;
        glm::ivec3 before = at;
        before[axis] -= kSize;
        at[axis] += tile.size;
        pass_face(before, axis, false);
        pass_face(at, axis, true);
      }
    }
  }
  return faces;
}

template <class T>
TileFaces faces_of_tiles(const SparseSamples& samples, const ScalarField& field, double iso) {
  if (samples.tiles.empty()) return {};
  const SparseLookup lookup(samples);
  return tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::size_t>(0, samples.tiles.size(), 16), TileFaces{},
      [&](const tbb::blocked_range<std::size_t>& range, TileFaces faces) {
        for (std::size_t t = range.begin(); t != range.end(); ++t) {
          const TileFaces more = faces_of_tile<T>(samples.tiles[t], samples, lookup, field, iso);
          faces.crossings += more.crossings;
          faces.places += more.places;
        }
        return faces;
      },
      [](TileFaces a, const TileFaces& b) {
        return TileFaces{a.crossings + b.crossings, a.places + b.places};
      });
}

}  // namespace

std::uint64_t count_vertices(const ScalarField& field, double iso, const std::optional<IndexBox>& box) {
  const auto* dense = std::get_if<DenseSamples>(&field.samples);
  if (dense == nullptr) return box ? 0 : count_in_blocks(field, iso);
  IndexBox samples = field.extents();
  if (box) samples = {glm::max(samples.min, box->min), glm::min(samples.max, box->max)};
  if (samples.empty()) return 0;
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    return tbb::parallel_deterministic_reduce(
        tbb::blocked_range<int>(samples.min.z, samples.max.z + 1), std::uint64_t{0},
        [&](const tbb::blocked_range<int>& planes, std::uint64_t crossings) {
          for (int k = planes.begin(); k != planes.end(); ++k) {
            for (int j = samples.min.y; j <= samples.max.y; ++j) {
              crossings += count_from_row<T>(field, *dense, samples, iso, j, k);
            }
          }
          return crossings;
        },
        std::plus<>{});
  });
}

std::uint64_t estimate_vertices(const ScalarField& field, double iso) {
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) -> std::uint64_t {
    if (const auto* dense = std::get_if<DenseSamples>(&field.samples)) {
      const auto row_length = static_cast<std::size_t>(dense->dims.x);
      const std::span<const T> all(static_cast<const T*>(dense->data), dense->count());
      return 3 * tbb::parallel_deterministic_reduce(
                     tbb::blocked_range<std::size_t>(0, all.size() / row_length, 64), std::uint64_t{0},
                     [&](const tbb::blocked_range<std::size_t>& rows, std::uint64_t crossings) {
                       for (std::size_t row = rows.begin(); row != rows.end(); ++row) {
                         crossings += count_crossings(all.subspan(row * row_length, row_length), field, iso);
                       }
                       return crossings;
                     },
                     std::plus<>{});
    }
    // A liquid at rest faces one axis alone.
    constexpr std::uint64_t kSide = SparseBlock::kSize;
    const std::uint64_t of_blocks = count_in_blocks(field, iso) * kSide / (kSide - 1);  // one edge in eight leaves one
    return of_blocks + faces_of_tiles<T>(std::get<SparseSamples>(field.samples), field, iso).crossings;
  });
}

std::uint64_t estimate_places(const ScalarField& field, double iso) {
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  if (sparse == nullptr) return 0;
  const bool background = is_inside(field, iso, sparse->background);
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) -> std::uint64_t {
    return tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(0, sparse->blocks.size(), 64), faces_of_tiles<T>(*sparse, field, iso).places,
        [&](const tbb::blocked_range<std::size_t>& range, std::uint64_t places) {
          for (std::size_t b = range.begin(); b != range.end(); ++b) {
            places += places_at<T>(sparse->blocks[b], *sparse, field, iso, background);
          }
          return places;
        },
        std::plus<>{});
  });
}

}  // namespace isoextract::field
