// Tells when all slices of a slab have come, in any order, from several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <vector>

#include "extract/dense_input.hpp"

namespace isoextract::extract {

// A slab needs its own slices and the first slice of the next slab.
class SlabCountdown {
 public:
  explicit SlabCountdown(int slices) : to_come_(static_cast<std::size_t>((slices + kBrickRows - 1) / kBrickRows)) {
    for (std::size_t slab = 0; slab < to_come_.size(); ++slab) {
      to_come_[slab] = std::min(kSlabSlices, slices - kBrickRows * static_cast<int>(slab));
    }
  }

  // Calls complete(slab) for each slab whose last missing slice is `slice`. What a thread wrote before it told of a
  // slice can be read then.
  template <class Complete>
  void tell(int slice, const Complete& complete) {
    const int slab = slice / kBrickRows;
    if (is_last_of(slab)) complete(slab);
    if (slice % kBrickRows == 0 && slab > 0 && is_last_of(slab - 1)) complete(slab - 1);
  }

 private:
  [[nodiscard]] bool is_last_of(int slab) { return --to_come_[static_cast<std::size_t>(slab)] == 0; }

  std::vector<std::atomic<int>> to_come_;
};

}  // namespace isoextract::extract
