// Views of one slab of samples after another, for one thread. Brings the samples into memory if they are not.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "base/allocation_error.hpp"
#include "base/error.hpp"
#include "extract/dense_input.hpp"
#include "field/sample_layers.hpp"

namespace isoextract::extract {

// The slices that work on a slab of a region reads: its own, the next one, and `around` more on either side.
struct SlabReach {
  field::IndexBox region;
  int around = 0;

  static constexpr int kOfGradients = 2;  // one-sided differences at the data boundary

  [[nodiscard]] int most_slices() const { return kSlabSlices + 2 * around; }
};

template <class T>
class SlabViews {
 public:
  // `whole` is the view of all samples. If `layers` is not null, the view has no samples, and a window gets them.
  // Fails as SampleLayers::open().
  [[nodiscard]] static Result<SlabViews> open(const DenseView<T>& whole, const field::SampleLayers* layers,
                                              const SlabReach& reach) {
    SlabViews views(whole, reach);
    if (layers != nullptr) views.window_ = TRY(layers->open(std::min(reach.most_slices(), whole.dims.z)));
    return views;
  }

  // Returns a view of all samples, in which those that slab `bk` of the region needs can be read, until the next call.
  // Fails as SampleLayers::Window::move_to().
  [[nodiscard]] Result<DenseView<T>> show(int bk) {
    DenseView<T> view = whole_;
    if (!window_) return view;
    const int first = reach_.region.min.z + kBrickRows * bk;
    const int begin = std::max(first - reach_.around, 0);
    const int end = std::min(first + kSlabSlices + reach_.around, whole_.dims.z);
    view.data = static_cast<const T*>(TRY(window_->move_to(begin, end)));
    view.first_slice = begin;
    return view;
  }

 private:
  SlabViews(const DenseView<T>& whole, const SlabReach& reach) : whole_(whole), reach_(reach) {}

  DenseView<T> whole_;
  SlabReach reach_;
  std::unique_ptr<field::SampleLayers::Window> window_;  // null if all samples are in memory
};

// Fails with ErrorCode::out_of_memory if the window of one more thread would take more than a fourth of the address
// space that is left: threads allocate memory, too.
template <class T>
[[nodiscard]] Result<void> check_room_for_window(const field::ScalarField& field, const DenseView<T>& whole,
                                                 const SlabReach& reach) {
  const auto slice_bytes = static_cast<std::uint64_t>(whole.stride_z) * sizeof(T);
  const auto left = address_space_left();
  if (!left || slice_bytes * static_cast<std::uint64_t>(reach.most_slices()) <= *left / 4) return {};
  return tl::unexpected(allocation_error(field.source + ": no address space for the samples of another thread"));
}

// Compares the samples of slab `bk` of a region, which `view` shows, and of the slice behind it with iso. Fills their
// masks; returns the facts about the samples of the slab alone. `requests` are those of the pass over the region.
template <class T>
SliceSides mark_slab(const DenseView<T>& view, const InsideThreshold<T>& threshold, int bk, DenseMasks& masks,
                     PageRequests& requests) {
  SliceSides sides;
  const int end = std::min(kBrickRows * (bk + 1), view.dims.z);
  masks.move_to(kBrickRows * bk);
  for (int k = kBrickRows * bk; k < std::min(end + 1, view.dims.z); ++k) {
    const SliceSides slice = classify_slice(view, threshold, masks, k, requests);
    if (k < end) sides.add(slice);
  }
  return sides;
}

// Returns the index of the first NaN sample of the region; (0, 0, 0) if there is none. Fails as SlabViews.
template <class T>
[[nodiscard]] Result<glm::ivec3> first_nan(const DenseView<T>& whole, const field::SampleLayers* layers,
                                           const field::IndexBox& region) {
  auto views = TRY(SlabViews<T>::open(whole, layers, {region}));
  const int slices = static_cast<int>(region.dims().z);
  for (int bk = 0; kBrickRows * bk < slices; ++bk) {
    const DenseView<T> view = part_of(TRY(views.show(bk)), region);
    const auto found = first_nan(view, kBrickRows * bk, std::min(kBrickRows * (bk + 1), slices));
    if (found) return region.min + *found;
  }
  return glm::ivec3(0);
}

}  // namespace isoextract::extract
