// Parallel passes over the stored samples of a field, dense or sparse.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "field/samples.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

inline constexpr std::size_t kBlockSamples = std::size_t{SparseBlock::kSize} * SparseBlock::kSize * SparseBlock::kSize;

// Reduces body(partial, values) over all stored samples; sparse samples come as whole blocks. The order of joins does
// not depend on the number of threads.
template <class T, class Partial, class Body, class Join>
[[nodiscard]] Partial reduce_stored(const Samples& samples, const Partial& identity, const Body& body, const Join& join,
                                    Progress* progress) {
  constexpr std::size_t kGrain = 1U << 16U;  // samples per task; fixed, so that sums do not depend on threads
  const auto* dense = std::get_if<DenseSamples>(&samples);
  std::span<const SparseBlock> blocks;
  if (dense == nullptr) blocks = std::get<SparseSamples>(samples).blocks;
  const std::size_t count = dense != nullptr ? dense->count() : blocks.size();
  if (progress != nullptr) progress->begin("measuring", count);
  return reduce_ranges(
      count, dense != nullptr ? kGrain : kGrain / kBlockSamples, identity,
      [&](std::size_t begin, std::size_t end, Partial partial) {
        if (dense != nullptr) {
          body(partial, std::span<const T>(static_cast<const T*>(dense->data) + begin, end - begin));
          dense->leave(begin, end);
        } else {
          for (std::size_t b = begin; b != end; ++b) {
            body(partial, std::span<const T>(static_cast<const T*>(blocks[b].values), kBlockSamples));
          }
        }
        if (progress != nullptr) progress->advance(end - begin);
        return partial;
      },
      join);
}

// The values of sparse samples that only tell the side: the background and, in a level set, its negative far inside.
// The number of such samples in blocks depends on where blocks begin, not on the field.
struct FarValues {
  double background = 0;
  double inside = 0;

  FarValues(const ScalarField& field, const SparseSamples& samples)
      : background(samples.background),
        inside(field.kind == FieldKind::level_set ? -samples.background : samples.background) {}
  [[nodiscard]] bool has(double stored) const { return stored == background || stored == inside; }
};

// Like reduce_stored(), but without far values.
template <class T, class Partial, class Body, class Join>
[[nodiscard]] Partial reduce_samples(const ScalarField& field, const Partial& identity, const Body& body,
                                     const Join& join, Progress* progress) {
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  std::optional<FarValues> far;
  if (sparse != nullptr) far.emplace(field, *sparse);
  const auto without_far = [&](Partial& partial, std::span<const T> values) {
    if (!far) {
      body(partial, values);
      return;
    }
    std::array<T, kBlockSamples> kept;
    std::size_t count = 0;
    for (const T value : values) {
      kept[count] = value;
      count += far->has(static_cast<double>(value)) ? 0 : 1;
    }
    body(partial, std::span<const T>(kept.data(), count));
  };
  return reduce_stored<T>(field.samples, identity, without_far, join, progress);
}

inline std::uint64_t tile_voxels(const SparseTile& tile) {
  const auto side = static_cast<std::uint64_t>(tile.size);
  return side * side * side;
}

// Calls function(stored value, voxels) for each tile that does not have a far value.
template <class Function>
void for_each_tile(const ScalarField& field, const Function& function) {
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  if (sparse == nullptr) return;
  const FarValues far(field, *sparse);
  for (const SparseTile& tile : sparse->tiles) {
    if (!far.has(tile.value)) function(tile.value, tile_voxels(tile));
  }
}

// Runs body(counts, values) on the samples that reduce_samples() visits. Each thread has its own counts: a vector of
// `size` zeros at first. Returns their sums.
template <class T, class Body>
[[nodiscard]] std::vector<std::uint64_t> count_samples(const ScalarField& field, std::size_t size, const Body& body,
                                                       Progress* progress) {
  tbb::enumerable_thread_specific<std::vector<std::uint64_t>> parts([&] { return std::vector<std::uint64_t>(size); });
  static_cast<void>(reduce_samples<T>(
      field, std::uint64_t{0}, [&](std::uint64_t&, std::span<const T> values) { body(parts.local(), values); },
      std::plus<>{}, progress));
  std::vector<std::uint64_t> sums(size);
  for (const auto& part : parts) std::ranges::transform(part, sums, sums.begin(), std::plus<>{});
  return sums;
}

}  // namespace isoextract::field
