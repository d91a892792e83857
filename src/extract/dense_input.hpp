// Steps that every backend takes with dense samples before it looks for the surface.
#pragma once

#include <optional>

#include "base/stopwatch.hpp"
#include "extract/dense_masks.hpp"
#include "extract/mesh_assembly.hpp"

namespace isoextract::extract {

inline constexpr int kBrickRows = 8;                // a brick has 64x8x8 cells: 8x8 rows of one mask word each
inline constexpr int kSlabSlices = kBrickRows + 1;  // slices of samples in a slab; a slab is a layer of bricks

// Returns the box of samples to extract from. Fails with ErrorCode::input if an axis has more samples than an extractor
// can number (2^30), or if the field or options.region contains no cell.
[[nodiscard]] Result<field::IndexBox> dense_region(const field::ScalarField& field, const field::DenseSamples& samples,
                                                   const ExtractOptions& options);

template <class T>
[[nodiscard]] DenseView<T> dense_view(const field::DenseSamples& samples) {
  const std::int64_t stride_y = samples.dims.x;
  return {static_cast<const T*>(samples.data), samples.dims, stride_y, stride_y * samples.dims.y,
          samples.releases_pages()};
}

template <class T>
[[nodiscard]] DenseView<T> part_of(const DenseView<T>& whole, const field::IndexBox& region) {
  const std::ptrdiff_t first = region.min.y * whole.stride_y + region.min.x;
  return {whole.data != nullptr ? whole.data + first : nullptr,
          glm::ivec3(region.dims()),
          whole.stride_y,
          whole.stride_z,
          whole.transient,
          whole.first_slice - region.min.z};
}

// Returns uninitialized masks, one bit a sample, with room for `slices` of the dims.z slices along z. They keep their
// memory reserved in `context` as long as they live. Fails with ErrorCode::out_of_memory.
[[nodiscard]] Result<DenseMasks> make_masks(const field::ScalarField& field, const glm::ivec3& dims, int slices,
                                            const Context& context);
// Returns masks for all samples.
[[nodiscard]] inline Result<DenseMasks> make_masks(const field::ScalarField& field, const glm::ivec3& dims,
                                                   const Context& context) {
  return make_masks(field, dims, dims.z, context);
}
// Compares the samples of `view` with the iso value; fills `masks` and the classification figures of `stats`. `low` is
// the index of the view's first sample in the field. Returns the threshold of inside samples. Returns nullopt if no
// number of the sample type is inside; the bits of `masks` are then invalid, and `stats` may be unfilled. Fails with
// ErrorCode::input for NaN samples under NanPolicy::error.
template <class T>
[[nodiscard]] Result<std::optional<InsideThreshold<T>>> classify_dense(const field::ScalarField& field,
                                                                       const DenseView<T>& view, const glm::ivec3& low,
                                                                       const ExtractOptions& options, DenseMasks& masks,
                                                                       ExtractStats& stats, const Context& context) {
  const Stopwatch watch;
  const auto threshold = find_inside_threshold<T>({field.kind, options.iso}, field.scale);
  if (!threshold && !(field::is_floating_sample<T> && options.nan == NanPolicy::error)) return threshold;
  // Without a threshold no sample is inside, but NaN samples must still be found.
  stats.nan_samples = classify(view, threshold.value_or(InsideThreshold<T>{}), masks, &context.progress());
  const glm::u64vec3 dims(view.dims);
  stats.samples_classified = dims.x * dims.y * dims.z;
  if (stats.nan_samples != 0 && options.nan == NanPolicy::error) {
    return nan_error(field, stats.nan_samples, low + first_nan(view, 0, view.dims.z).value_or(glm::ivec3(0)));
  }
  stats.classify = watch.elapsed();
  return threshold;
}

}  // namespace isoextract::extract
