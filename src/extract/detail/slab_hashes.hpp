// Tells whether the masks of a slab are those that were counted, if passes make them anew.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "extract/dense_input.hpp"
#include "extract/detail/slab_shares.hpp"

namespace isoextract::extract {

class SlabHashes {
 public:
  SlabHashes() = default;
  explicit SlabHashes(const SlabRange& slabs)
      : first_(slabs.begin), hashes_(static_cast<std::size_t>(std::max(slabs.count(), 0))) {}

  // Keeps the hash of the masks of slab `bk`. Several threads may do so at once, for different slabs.
  void keep(int bk, const DenseMasks& masks) { at(bk) = hash_of(bk, masks); }
  [[nodiscard]] bool is_kept(int bk, const DenseMasks& masks) { return at(bk) == hash_of(bk, masks); }

 private:
  [[nodiscard]] std::uint64_t& at(int bk) { return hashes_[static_cast<std::size_t>(bk - first_)]; }
  [[nodiscard]] static std::uint64_t hash_of(int bk, const DenseMasks& masks) {
    return masks.hash(kBrickRows * bk, std::min(kBrickRows * bk + kSlabSlices, masks.dims().z));
  }

  int first_ = 0;
  std::vector<std::uint64_t> hashes_;
};

}  // namespace isoextract::extract
