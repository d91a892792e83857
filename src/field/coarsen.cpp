#include "field/coarsen.hpp"

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "field/detail/without_samples.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {
namespace {

template <class T>
using Coarse = std::conditional_t<std::is_same_v<T, double>, double, float>;

Affine coarse_transform(const Affine& fine, int factor) {
  Affine coarse = fine;
  coarse.offset = fine(glm::dvec3((factor - 1) / 2.0));
  coarse.linear *= static_cast<double>(factor);
  return coarse;
}

// Returns the mean of value(p) over the factor^3 samples p that begin at `first`.
template <class F>
double mean(const glm::ivec3& first, int factor, const F& value) {
  double sum = 0;
  for (int k = 0; k < factor; ++k) {
    for (int j = 0; j < factor; ++j) {
      for (int i = 0; i < factor; ++i) sum += value(first + glm::ivec3(i, j, k));
    }
  }
  return sum / (static_cast<double>(factor) * factor * factor);
}

template <class T>
Result<Samples> coarsen_dense(const ScalarField& field, const DenseSamples& fine, int factor, const Context& context) {
  DenseSamples coarse;
  coarse.type = sample_type_of<Coarse<T>>();
  coarse.dims = fine.dims / factor;
  if (glm::any(glm::lessThan(coarse.dims, glm::ivec3(2)))) {
    return fail(ErrorCode::input,
                fmt::format("{}: coarsening by {} needs at least {} samples along each axis, found {} x {} x {}",
                            field.source, factor, 2 * factor, fine.dims.x, fine.dims.y, fine.dims.z));
  }
  auto made = TRY(make_reserved_buffer<Coarse<T>>(
      coarse.count(), context, fmt::format("{}: the samples of the grid coarsened by {}", field.source, factor)));
  Coarse<T>* const values = made->values.data();
  const glm::i64vec3 dims(fine.dims);
  const auto* source = static_cast<const T*>(fine.data);
  context.progress().begin("making the field coarser", static_cast<std::uint64_t>(coarse.dims.z));
  for_each_index(coarse.dims.z, [&](int k) {
    if (context.cancelled()) return;
    auto* row = values + static_cast<std::size_t>(coarse.dims.x) * static_cast<std::size_t>(coarse.dims.y) *
                             static_cast<std::size_t>(k);
    for (int j = 0; j < coarse.dims.y; ++j) {
      for (int i = 0; i < coarse.dims.x; ++i) {
        *row++ = static_cast<Coarse<T>>(mean(factor * glm::ivec3(i, j, k), factor, [&](const glm::ivec3& p) {
          return static_cast<double>(source[p.x + dims.x * (p.y + dims.y * p.z)]);
        }));
      }
    }
    context.progress().advance(1);
  });
  TRY(context.check());
  coarse.data = values;
  coarse.owner = std::move(made);
  return coarse;
}

int floor_divided(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

template <class T>
Result<Samples> coarsen_sparse(const ScalarField& field, const SparseSamples& fine, int factor,
                               const Context& context) {
  constexpr int kSize = SparseBlock::kSize;
  constexpr int kBlockSamples = kSize * kSize * kSize;
  SparseSamples coarse;
  coarse.type = sample_type_of<Coarse<T>>();
  const auto rounded = [](double value) { return static_cast<double>(static_cast<Coarse<T>>(value)); };
  coarse.background = rounded(fine.background);
  // A tile that fills coarse blocks stays a tile, unless rounding makes its value the background's. Smaller tiles go
  // into blocks.
  std::vector<glm::ivec3> origins;
  const auto add_block = [&](const glm::ivec3& p) {
    origins.emplace_back(floor_divided(p.x, kSize * factor) * kSize, floor_divided(p.y, kSize * factor) * kSize,
                         floor_divided(p.z, kSize * factor) * kSize);
  };
  for (const SparseBlock& block : fine.blocks) add_block(block.origin);
  for (const SparseTile& tile : fine.tiles) {
    if (tile.size < kSize * factor) {
      add_block(tile.origin);
    } else if (const double value = rounded(tile.value); value != coarse.background) {
      coarse.tiles.push_back({tile.origin / factor, tile.size / factor, value});
    }
  }
  const auto key = [](const glm::ivec3& p) { return std::tuple(p.x, p.y, p.z); };
  std::ranges::sort(origins, {}, key);
  origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
  auto made = TRY(make_reserved_buffer<Coarse<T>>(
      origins.size() * kBlockSamples, context,
      fmt::format("{}: the samples of the grid coarsened by {}", field.source, factor)));
  Coarse<T>* const values = made->values.data();
  const auto lookup_memory = TRY(context.reserve(SparseLookup::bytes(fine), field.source + ": the index of blocks"));
  const SparseLookup lookup(fine);
  context.progress().begin("making the field coarser", origins.size());
  for_each_index(origins.size(), [&](std::size_t b) {
    if (context.cancelled()) return;
    for (int v = 0; v < kBlockSamples; ++v) {
      const glm::ivec3 p = origins[b] + glm::ivec3(v >> 6, v >> 3 & 7, v & 7);
      values[b * kBlockSamples + static_cast<std::size_t>(v)] =
          static_cast<Coarse<T>>(mean(factor * p, factor, [&](const glm::ivec3& q) {
            const glm::ivec3 origin = block_origin(q);
            const std::int32_t block = lookup.block(origin);
            return block >= 0 ? static_cast<double>(static_cast<const T*>(fine.blocks[block].values)[block_offset(q)])
                              : lookup.constant(origin);
          }));
    }
    context.progress().advance(1);
  });
  TRY(context.check());
  for (std::size_t b = 0; b < origins.size(); ++b) {
    coarse.blocks.push_back({origins[b], values + b * kBlockSamples});
  }
  const IndexBox& active = fine.active_box;
  if (!active.empty()) {
    for (int axis = 0; axis < 3; ++axis) {
      coarse.active_box.min[axis] = floor_divided(active.min[axis], factor);
      coarse.active_box.max[axis] = floor_divided(active.max[axis], factor);
    }
  }
  coarse.active_voxels = fine.active_voxels / (static_cast<std::uint64_t>(factor) * factor * factor);
  coarse.owner = std::move(made);
  return coarse;
}

}  // namespace

Result<ScalarField> coarsen(const ScalarField& field, int factor, const Context& context) {
  auto samples = TRY(visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    if (const auto* dense = std::get_if<DenseSamples>(&field.samples)) {
      return coarsen_dense<T>(field, *dense, factor, context);
    }
    return coarsen_sparse<T>(field, std::get<SparseSamples>(field.samples), factor, context);
  }));
  ScalarField coarse = without_samples(field);
  coarse.index_to_world = coarse_transform(field.index_to_world, factor);
  coarse.index_to_file = coarse_transform(field.index_to_file, factor);
  coarse.samples = std::move(samples);
  return coarse;
}

}  // namespace isoextract::field
