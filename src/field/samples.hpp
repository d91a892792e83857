// How the samples of a field lie in memory: dense arrays, or sparse blocks over tiles over a background.
// Samples are kept in the type they were stored as and are never copied to change representation.
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

// Inclusive box of sample indices (i, j, k). Empty if any max < min.
struct IndexBox {
  glm::ivec3 min{0};
  glm::ivec3 max{-1};

  [[nodiscard]] glm::i64vec3 dims() const { return glm::i64vec3(max) - glm::i64vec3(min) + glm::i64vec3(1); }
  [[nodiscard]] bool empty() const { return max.x < min.x || max.y < min.y || max.z < min.z; }
  friend bool operator==(const IndexBox&, const IndexBox&) = default;
};

// A full box of samples. i (x) varies fastest: sample (i, j, k) is element i + dims.x * (j + dims.y * k).
// Index (0, 0, 0) is the first sample. All dims are at least 1.
struct DenseSamples {
  SampleType type = SampleType::f32;
  glm::ivec3 dims{0};
  std::shared_ptr<const void> owner;  // keeps `data` alive
  const void* data = nullptr;         // dims.x * dims.y * dims.z values in native byte order, aligned for their type
  bool file_backed = false;  // data is a read-only mapping of a file: pages given back come again from the file
  // Set, at any time, when a part of the file is no longer there: samples of it are 0. `owner` keeps it alive; null
  // where nothing can be lost.
  const std::atomic<bool>* loss = nullptr;

  // Asked after work on the samples: what came of it is worth nothing if they are not what the file held.
  [[nodiscard]] bool lost() const { return loss != nullptr && loss->load(std::memory_order_acquire); }

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(dims.x) * static_cast<std::size_t>(dims.y) * static_cast<std::size_t>(dims.z);
  }
};

// Indices of sparse samples lie within +- this, so that index arithmetic around and between them fits into an int.
inline constexpr int kMaxSparseIndex = 1 << 29;

// 8 x 8 x 8 samples. Sample origin + (x, y, z) is values[x << 6 | y << 3 | z] (z fastest: OpenVDB's leaf layout).
struct SparseBlock {
  static constexpr int kSize = 8;
  glm::ivec3 origin;             // a multiple of 8 in every axis
  const void* values = nullptr;  // 512 values of the samples' type
};

// A cube of `size` samples a side (a power of two from 8 on, at a multiple of itself) that all have one value.
struct SparseTile {
  glm::ivec3 origin;
  int size;
  double value;
};

// An unbounded grid: blocks, tiles, and `background` everywhere else. No block lies in a tile and no two overlap.
// Inactive voxels and inactive tiles have a value like any other; whether a voxel is active plays no part.
struct SparseSamples {
  SampleType type = SampleType::f32;
  std::vector<SparseBlock> blocks;  // sorted by origin: x, then y, then z
  std::vector<SparseTile> tiles;    // only tiles whose value differs from the background
  double background = 0;            // exact: every sample type fits into double
  IndexBox active_box;              // of the active voxels, for `info` and messages; may be empty
  std::uint64_t active_voxels = 0;
  std::shared_ptr<const void> owner;  // keeps the blocks' values alive
};

using Samples = std::variant<DenseSamples, SparseSamples>;

}  // namespace isoextract::field
