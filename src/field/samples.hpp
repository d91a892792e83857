// The samples of a field in memory: a dense array, or sparse blocks and tiles over a background. A reader keeps the
// file's sample type if SampleType has it (64-bit integers become double). Operations such as resample() state the
// sample type of their result.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "field/sample_type.hpp"

namespace isoextract::field {

class SampleLayers;  // sample_layers.hpp

// An inclusive box of sample indices (i, j, k). Empty if max < min along any axis.
struct IndexBox {
  glm::ivec3 min{0};
  glm::ivec3 max{-1};

  [[nodiscard]] glm::i64vec3 dims() const { return glm::i64vec3(max) - glm::i64vec3(min) + glm::i64vec3(1); }
  [[nodiscard]] bool empty() const { return max.x < min.x || max.y < min.y || max.z < min.z; }
  [[nodiscard]] std::uint64_t count() const {  // samples in the box
    const glm::u64vec3 sizes(dims());
    return empty() ? 0 : sizes.x * sizes.y * sizes.z;
  }
  friend bool operator==(const IndexBox&, const IndexBox&) = default;
};

// A full box of samples. i (x) varies fastest: sample (i, j, k) is element i + dims.x * (j + dims.y * k). The first
// sample has index (0, 0, 0). All dims are at least 1.
struct DenseSamples {
  SampleType type = SampleType::f32;
  glm::ivec3 dims{0};
  std::shared_ptr<const void> owner;  // keeps `data` alive
  const void* data = nullptr;         // dims.x * dims.y * dims.z values in native byte order, aligned for their type
  bool file_backed = false;           // data is a read-only file mapping: its pages may be released (base/pages.hpp)
  // Set to true, at any time, when a part of the mapped file cannot be read (truncated, disk error): its samples are
  // then 0. `owner` keeps the flag alive. Null without a mapping.
  const std::atomic<bool>* loss = nullptr;

  // Set if `data` is in a temporary file: returns whether the disk lost samples; called with owner.get().
  bool (*is_lost_on_disk)(const void* owner) = nullptr;

  // Set instead of `data`, which is then null, only if the reader was asked for it (volume_io::ReadOptions::by_layers).
  // `owner` keeps it alive. The CPU extractor for mc and mt takes such samples, without caps and NanPolicy::hole.
  const SampleLayers* layers = nullptr;

  // Returns whether samples were lost. Call it after work on the samples: if true, the result is invalid.
  [[nodiscard]] bool lost() const {
    return (loss != nullptr && loss->load(std::memory_order_acquire)) ||
           (is_lost_on_disk != nullptr && is_lost_on_disk(owner.get()));
  }

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(dims.x) * static_cast<std::size_t>(dims.y) * static_cast<std::size_t>(dims.z);
  }

  // Returns whether passes over the samples should release the memory pages of parts after use: those of a large file.
  [[nodiscard]] bool releases_pages() const {
    constexpr std::uint64_t kLarge = std::uint64_t{64} << 20U;  // bytes
    return file_backed && count() * sample_size(type) >= kLarge;
  }
  // Does so for the samples [begin, end), if releases_pages().
  void leave(std::size_t begin, std::size_t end) const;
};

// Extractors refuse sparse samples whose indices are not within +- this (ErrorCode::input), so that index arithmetic on
// samples and their neighbors fits into an int. Readers do not check it.
inline constexpr int kMaxSparseIndex = 1 << 29;

// 8 x 8 x 8 samples. Sample origin + (x, y, z) is values[x << 6 | y << 3 | z]: z varies fastest, as in OpenVDB's
// leaves.
struct SparseBlock {
  static constexpr int kSize = 8;
  glm::ivec3 origin;             // a multiple of 8 in every axis
  const void* values = nullptr;  // 512 values of the samples' type
};

// A cube of size^3 samples with a single value. `size` is a power of two, at least 8, and divides the origin.
struct SparseTile {
  glm::ivec3 origin;
  int size;
  double value;
};

// An unbounded grid: blocks, tiles, and `background` everywhere else. Blocks and tiles do not overlap. The values of
// inactive voxels and tiles count like any other.
struct SparseSamples {
  SampleType type = SampleType::f32;
  std::vector<SparseBlock> blocks;    // sorted by origin: x, then y, then z
  std::vector<SparseTile> tiles;      // only tiles whose value differs from the background
  double background = 0;              // exact: every sample type fits into double
  IndexBox active_box;                // bounds of the active voxels; may be empty; resample() includes it in its box
  std::uint64_t active_voxels = 0;    // an estimate after coarsen()
  std::shared_ptr<const void> owner;  // keeps the blocks' values alive
};

using Samples = std::variant<DenseSamples, SparseSamples>;

}  // namespace isoextract::field
