#include "extract/dense_masks.hpp"

#include <atomic>

#include <tbb/parallel_for.h>

#include "extract/detail/classify_samples.hpp"

namespace isoextract::extract {

template <class T>
std::uint64_t classify(const DenseView<T>& view, const InsideThreshold<T>& threshold, DenseMasks& masks,
                       Progress* progress) {
  const auto [nx, ny, nz] = std::array{view.dims.x, view.dims.y, view.dims.z};
  std::atomic<std::uint64_t> nan{0};
  if (progress != nullptr) progress->begin("classifying samples", static_cast<std::uint64_t>(nz));
  tbb::parallel_for(0, nz, [&, nx = nx, ny = ny](int k) {
    std::uint64_t slice_nan = 0;
    for (int j = 0; j < ny; ++j) {
      std::uint64_t* bits = masks.row(j, k);
      slice_nan += classify_samples(view.row(j, k), static_cast<std::size_t>(nx), threshold, bits);
      bits[masks.words()] = 0;
    }
    view.leave_slices(k, k + 1);
    if (slice_nan != 0) nan.fetch_add(slice_nan, std::memory_order_relaxed);
    if (progress != nullptr) progress->advance(1);
  });
  return nan.load();
}

#define ISOEXTRACT_INSTANTIATE(T) \
  template std::uint64_t classify(const DenseView<T>&, const InsideThreshold<T>&, DenseMasks&, Progress*);
ISOEXTRACT_EACH_SAMPLE_TYPE(ISOEXTRACT_INSTANTIATE)
#undef ISOEXTRACT_INSTANTIATE

}  // namespace isoextract::extract
