#include "extract/dense_masks.hpp"

#include <atomic>

#include "base/parallel.hpp"
#include "extract/detail/classify_samples.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {

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
std::uint64_t classify(const DenseView<T>& view, const InsideThreshold<T>& threshold, DenseMasks& masks,
                       Progress* progress) {
  const auto [nx, ny, nz] = std::array{view.dims.x, view.dims.y, view.dims.z};
  std::atomic<std::uint64_t> nan{0};
  std::atomic<bool> boundary_inside{false};
  std::atomic<bool> boundary_outside{false};
  if (progress != nullptr) progress->begin("classifying samples", static_cast<std::uint64_t>(nz));
  for_each_index(nz, [&, nx = nx, ny = ny](int k) {
    std::uint64_t slice_nan = 0;
    BoundarySides slice_sides;
    for (int j = 0; j < ny; ++j) {
      std::uint64_t* bits = masks.row(j, k);
      slice_nan += classify_samples(view.row(j, k), static_cast<std::size_t>(nx), threshold, bits);
      bits[masks.words()] = 0;
      const BoundarySides sides = masks.boundary_of_row(j, k);
      slice_sides.inside |= sides.inside;
      slice_sides.outside |= sides.outside;
    }
    view.leave_slices(k, k + 1);
    if (slice_nan != 0) nan.fetch_add(slice_nan, std::memory_order_relaxed);
    if (slice_sides.inside) boundary_inside.store(true, std::memory_order_relaxed);
    if (slice_sides.outside) boundary_outside.store(true, std::memory_order_relaxed);
    if (progress != nullptr) progress->advance(1);
  });
  masks.set_boundary({boundary_inside.load(), boundary_outside.load()});
  return nan.load();
}

#define ISOEXTRACT_INSTANTIATE(T) \
  template std::uint64_t classify(const DenseView<T>&, const InsideThreshold<T>&, DenseMasks&, Progress*);
ISOEXTRACT_EACH_SAMPLE_TYPE(ISOEXTRACT_INSTANTIATE)
#undef ISOEXTRACT_INSTANTIATE

}  // namespace isoextract::extract
