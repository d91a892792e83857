// Reads the stored values at the corners of a batch of cells, from dense and sparse fields.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <glm/glm.hpp>

#include "render/detail/slab_batch.hpp"
#include "render/detail/volume_samples.hpp"

namespace isoextract::render::detail {

// Use one per thread: it caches the blocks that it read last.
template <class T>
class CornerReader {
 public:
  explicit CornerReader(const VolumeSamples& samples) : samples_(samples), dense_(samples.dense()) {
    const field::ValueScale& scale = samples.field().scale;
    const TransferFunction& transfer = samples.transfer();
    scale_ = {!scale.is_identity(), scale.slope, scale.intercept, transfer.min(), transfer.positions_per_value()};
  }

  // Reads the corners of the batch's cells and shades the batch.
  void shade(const SlabRay& ray, SlabBatch& batch) {
    if (dense_ != nullptr) {
      read_dense(batch);
      detail::shade(ray, scale_, samples_.transfer(), dense_corners_, batch);
    } else {
      read_sparse(batch);
      detail::shade(ray, scale_, samples_.transfer(), sparse_corners_, batch);
    }
  }

 private:
  // The smallest type that holds every value of T and converts to double in vector code.
  using Raw = std::conditional_t<std::is_integral_v<T> && !std::is_same_v<T, std::uint32_t>, std::int32_t,
                                 std::conditional_t<sizeof(T) <= 4 && field::is_floating_sample<T>, float, double>>;

  static Raw raw(T value) { return static_cast<Raw>(value); }

  void read_dense(const SlabBatch& batch) {
    const auto* values = static_cast<const T*>(dense_->data);
    const std::int64_t row = dense_->dims.x;
    const std::int64_t layer = row * dense_->dims.y;
    auto& at = dense_corners_.at;
    for (std::size_t i = 0; i < batch.size; ++i) {
      const T* p = values + (batch.cell[0][i] + row * batch.cell[1][i] + layer * batch.cell[2][i]);
      at[0][i] = raw(p[0]);
      at[1][i] = raw(p[1]);
      at[2][i] = raw(p[row]);
      at[3][i] = raw(p[row + 1]);
      p += layer;
      at[4][i] = raw(p[0]);
      at[5][i] = raw(p[1]);
      at[6][i] = raw(p[row]);
      at[7][i] = raw(p[row + 1]);
    }
  }

  void read_sparse(const SlabBatch& batch) {
    for (std::size_t i = 0; i < batch.size; ++i) {
      const glm::ivec3 cell(batch.cell[0][i], batch.cell[1][i], batch.cell[2][i]);
      if (const glm::ivec3 origin = field::block_origin(cell); origin != origin_) find_blocks(origin);
      for (std::size_t n = 0; n < 8; ++n) {
        const auto corner = static_cast<int>(n);
        const glm::ivec3 p = cell - origin_ + glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
        const auto block = static_cast<std::size_t>(p.x >> 3 | p.y >> 3 << 1 | p.z >> 3 << 2);
        sparse_corners_.at[n][i] =
            blocks_[block] != nullptr ? static_cast<double>(blocks_[block][field::block_offset(p)]) : constants_[block];
      }
    }
  }

  // Finds the eight blocks that contain corners of cells in the block at `origin`.
  void find_blocks(const glm::ivec3& origin) {
    origin_ = origin;
    const field::SparseLookup::Group places = samples_.lookup().group(origin);
    for (std::size_t n = 0; n < places.size(); ++n) {
      const std::int32_t place = places[n];
      blocks_[n] = place >= 0 ? static_cast<const T*>(samples_.sparse().blocks[static_cast<std::size_t>(place)].values)
                              : nullptr;
      if (place < 0) constants_[n] = samples_.lookup().constant_of(place);
    }
  }

  const VolumeSamples& samples_;
  const field::DenseSamples* dense_;
  PositionScale scale_;
  CornerSamples<Raw> dense_corners_;
  CornerSamples<double> sparse_corners_;
  glm::ivec3 origin_{std::numeric_limits<int>::max()};  // no block has this origin
  std::array<const T*, 8> blocks_{};
  std::array<double, 8> constants_{};
};

}  // namespace isoextract::render::detail
