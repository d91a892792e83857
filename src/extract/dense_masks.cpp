#include "extract/dense_masks.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/parallel.hpp"
#include "extract/detail/classify_samples.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {

std::uint64_t DenseMasks::hash(int begin, int end) const {
  return XXH3_64bits(row(0, begin), static_cast<std::size_t>(row(0, end) - row(0, begin)) * sizeof(std::uint64_t));
}

BoundarySides DenseMasks::boundary_of_row(int j, int k) const {
  const std::uint64_t* bits = row(j, k);
  const bool wholly = j == 0 || k == 0 || j == dims_.y - 1 || k == dims_.z - 1;
  if (!wholly) {
    const bool first = (bits[0] & 1) != 0;
    const bool last = (bits[words_ - 1] >> ((dims_.x - 1) % 64) & 1) != 0;
    return {first || last, !first || !last};
  }
  BoundarySides sides;
  for (int w = 0; w < words_; ++w) {
    sides.inside |= bits[w] != 0;
    sides.outside |= bits[w] != bits_below(w, dims_.x);
  }
  return sides;
}

template <class T>
SliceSides classify_slice(const DenseView<T>& view, const InsideThreshold<T>& threshold, DenseMasks& masks, int k,
                          PageRequests& requests) {
  constexpr auto kBlock = static_cast<std::ptrdiff_t>(PageRequests::kBlock / sizeof(T));
  SliceSides slice;
  const T* next_request = view.row(0, k);
  for (int j = 0; j < view.dims.y; ++j) {
    std::uint64_t* bits = masks.row(j, k);
    if (view.row(j, k) >= next_request) {
      requests.come_to(view.row(j, k));
      next_request = view.row(j, k) + kBlock;
    }
    slice.nan += classify_samples(view.row(j, k), static_cast<std::size_t>(view.dims.x), threshold, bits);
    bits[masks.words()] = 0;
    slice.add({0, masks.boundary_of_row(j, k)});
  }
  return slice;
}

template <class T>
std::uint64_t classify(const DenseView<T>& view, const InsideThreshold<T>& threshold, DenseMasks& masks,
                       Progress* progress, const std::function<bool(int slice, const SliceSides& facts)>& after_slice) {
  std::mutex mutex;
  SliceSides all;
  PageRequests requests = view.page_requests(0, view.dims.z);
  if (progress != nullptr) progress->begin("classifying samples", static_cast<std::uint64_t>(view.dims.z));
  std::atomic<int> next{0};
  const auto work = [&](int k) {
    const SliceSides slice = classify_slice(view, threshold, masks, k, requests);
    if (!after_slice) view.leave_slices(k, k + 1);
    {
      const std::lock_guard lock(mutex);
      all.add(slice);
    }
    if (after_slice && !after_slice(k, slice)) next = view.dims.z;
    if (progress != nullptr) progress->advance(1);
  };
  for_each_index(std::min(usable_threads(), view.dims.z), [&](int /*worker*/) {
    for (int k = next++; k < view.dims.z; k = next++) work(k);
  });
  masks.set_boundary(all.boundary);
  return all.nan;
}

#define ISOEXTRACT_INSTANTIATE(T)                                                                                      \
  template SliceSides classify_slice(const DenseView<T>&, const InsideThreshold<T>&, DenseMasks&, int, PageRequests&); \
  template std::uint64_t classify(const DenseView<T>&, const InsideThreshold<T>&, DenseMasks&, Progress*,              \
                                  const std::function<bool(int, const SliceSides&)>&);
ISOEXTRACT_EACH_SAMPLE_TYPE(ISOEXTRACT_INSTANTIATE)
#undef ISOEXTRACT_INSTANTIATE

}  // namespace isoextract::extract
