// Rows of samples along x, dense or sparse, as numbers. Private to resample.cpp.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>

#include "field/samples.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {

// y and z count from the low corner of the box.
template <class T>
class SampleRows {
 public:
  SampleRows(const Samples& samples, const IndexBox& box)
      : dense_(std::get_if<DenseSamples>(&samples)), sparse_(std::get_if<SparseSamples>(&samples)), box_(box) {
    if (sparse_ != nullptr) lookup_.emplace(*sparse_);
  }

  // Writes the samples of a row to `row`.
  void read(int y, int z, double* row) const {
    if (dense_ != nullptr) {
      const glm::i64vec3 dims(dense_->dims);
      const T* from = static_cast<const T*>(dense_->data) + dims.x * (y + dims.y * z);
      std::transform(from, from + dims.x, row, [](T value) { return static_cast<double>(value); });
      return;
    }
    const glm::ivec3 first = box_.min + glm::ivec3(0, y, z);
    for (int x = first.x; x <= box_.max.x;) {
      const glm::ivec3 origin = block_origin({x, first.y, first.z});
      const int end = std::min(origin.x + SparseBlock::kSize, box_.max.x + 1);
      const std::int32_t block = lookup_->block(origin);
      if (block < 0) {
        row = std::fill_n(row, end - x, lookup_->constant(origin));
        x = end;
        continue;
      }
      const auto* values = static_cast<const T*>(sparse_->blocks[block].values);
      for (; x < end; ++x) *row++ = static_cast<double>(values[block_offset({x, first.y, first.z})]);
    }
  }

  // Releases the pages of rows begin_y to end_y - 1 in planes begin_z to end_z - 1 of a large mapped file.
  void leave(int begin_y, int end_y, int begin_z, int end_z) const {
    if (dense_ == nullptr) return;
    const auto first = [&](int y, int z) {
      return static_cast<std::size_t>(dense_->dims.x) *
             (static_cast<std::size_t>(y) + static_cast<std::size_t>(dense_->dims.y) * static_cast<std::size_t>(z));
    };
    if (begin_y == 0 && end_y == dense_->dims.y) return dense_->leave(first(0, begin_z), first(0, end_z));
    for (int z = begin_z; z < end_z; ++z) dense_->leave(first(begin_y, z), first(end_y, z));
  }

 private:
  const DenseSamples* dense_;
  const SparseSamples* sparse_;
  std::optional<SparseLookup> lookup_;
  IndexBox box_;
};

}  // namespace isoextract::field
