// Code shared by all blur filters.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "field/detail/blurred_blocks.hpp"
#include "field/detail/without_samples.hpp"
#include "field/scalar_field.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {

inline constexpr int kBlurBlockSide = SparseBlock::kSize;
inline constexpr std::size_t kBlurBlockSamples = std::size_t{kBlurBlockSide} * kBlurBlockSide * kBlurBlockSide;

inline std::string memory_label(const ScalarField& field) { return field.source + ": its blurred samples"; }

inline std::uint64_t max_threads() { return static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency()) + 1; }

// Calls f(k, first, end) in parallel for each slice k of dense samples: the elements [first, end). f() reads samples of
// `around` slices on either side, too. The pages of a large mapped file are released afterwards.
template <class F>
void for_each_slice(const DenseSamples& samples, int around, const Context& context, const F& f) {
  const std::size_t slice = static_cast<std::size_t>(samples.dims.x) * static_cast<std::size_t>(samples.dims.y);
  for_each_index(samples.dims.z, [&](int k) {
    if (context.cancelled()) return;
    f(k, static_cast<std::size_t>(k) * slice, static_cast<std::size_t>(k + 1) * slice);
    samples.leave(static_cast<std::size_t>(std::max(k - around, 0)) * slice,
                  static_cast<std::size_t>(std::min(k + around + 1, samples.dims.z)) * slice);
  });
}

// Gathers a block of a sparse grid and the samples around it, z fastest.
template <class T>
class Surroundings {
 public:
  Surroundings(const SparseSamples& samples, const SparseLookup& lookup, const glm::ivec3& reach)
      : samples_(samples), lookup_(lookup), reach_(reach), dims_(kBlurBlockSide + 2 * reach) {}

  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(dims_.x) * static_cast<std::size_t>(dims_.y) * static_cast<std::size_t>(dims_.z);
  }
  [[nodiscard]] const glm::ivec3& dims() const { return dims_; }

  // Writes the samples of the block at `origin` and those around it to `values`, which has size() elements.
  void gather(const glm::ivec3& origin, double* values) const {
    const glm::ivec3 low = origin - reach_;
    const glm::ivec3 high = low + dims_;  // exclusive
    for (int x = block_origin(low).x; x < high.x; x += kBlurBlockSide) {
      for (int y = block_origin(low).y; y < high.y; y += kBlurBlockSide) {
        for (int z = block_origin(low).z; z < high.z; z += kBlurBlockSide) {
          const glm::ivec3 place(x, y, z);
          take(place, glm::max(place, low), glm::min(place + kBlurBlockSide, high), low, values);
        }
      }
    }
  }

 private:
  void take(const glm::ivec3& place, const glm::ivec3& from, const glm::ivec3& to, const glm::ivec3& low,
            double* values) const {
    const std::int32_t stored = lookup_.place(place);
    const T* block =
        stored >= 0 ? static_cast<const T*>(samples_.blocks[static_cast<std::size_t>(stored)].values) : nullptr;
    const double constant = block != nullptr ? 0 : lookup_.constant_of(stored);
    for (int x = from.x; x < to.x; ++x) {
      for (int y = from.y; y < to.y; ++y) {
        const glm::ivec3 at = glm::ivec3(x, y, from.z) - low;
        double* row =
            values +
            (static_cast<std::size_t>(at.x) * static_cast<std::size_t>(dims_.y) + static_cast<std::size_t>(at.y)) *
                static_cast<std::size_t>(dims_.z) +
            at.z;
        const std::size_t count = static_cast<std::size_t>(to.z - from.z);
        if (block == nullptr) {
          std::fill_n(row, count, constant);
        } else {
          const T* values_of = block + block_offset({x, y, from.z});
          std::transform(values_of, values_of + count, row, [](T value) { return static_cast<double>(value); });
        }
      }
    }
  }

  const SparseSamples& samples_;
  const SparseLookup& lookup_;
  glm::ivec3 reach_;
  glm::ivec3 dims_;
};

// Filters a sparse field: fill(dims, values, scratch, block) computes a block from the gathered samples around it.
// `scratch` has room for `scratch_per_sample` - 1 numbers for each gathered sample.
template <class T, class Out, class Fill>
Result<Samples> blur_sparse(const ScalarField& field, const SparseSamples& data, const glm::ivec3& reach,
                            std::size_t scratch_per_sample, const Context& context, const Fill& fill) {
  const std::string what = memory_label(field);
  const auto lookup_memory = TRY(context.reserve(SparseLookup::bytes(data), what));
  const SparseLookup lookup(data);
  auto places = TRY(find_blurred_blocks(data, lookup, std::max({reach.x, reach.y, reach.z}), what, context));
  const Surroundings<T> around(data, lookup, reach);
  const std::size_t scratch_size = scratch_per_sample * around.size();
  const auto scratch_memory = TRY(context.reserve(max_threads() * scratch_size * sizeof(double), what));
  const std::size_t count = places.origins.size();
  auto made = TRY(make_reserved_buffer<Out>(count * kBlurBlockSamples, context, what));
  Out* const values = made->values.data();
  tbb::enumerable_thread_specific<std::vector<double>> scratch([&] { return std::vector<double>(scratch_size); });
  for_each_index(count, [&](std::size_t b) {
    if (context.cancelled()) return;
    std::vector<double>& own = scratch.local();
    around.gather(places.origins[b], own.data());
    fill(around.dims(), own.data(), own.data() + around.size(), values + b * kBlurBlockSamples);
    context.progress().advance(1);
  });
  TRY(context.check());
  SparseSamples blurred;
  blurred.type = sample_type_of<Out>();
  blurred.background = data.background;
  blurred.active_box = data.active_box;
  blurred.active_voxels = data.active_voxels;
  blurred.tiles = std::move(places.tiles);
  blurred.blocks.reserve(count);
  for (std::size_t b = 0; b < count; ++b) blurred.blocks.push_back({places.origins[b], values + b * kBlurBlockSamples});
  blurred.owner = std::move(made);
  return blurred;
}

}  // namespace isoextract::field
