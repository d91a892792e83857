// The labels of the voxels around the corners of one chunk.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "extract/detail/corner_words.hpp"
#include "extract/detail/label_chunks.hpp"

namespace isoextract::extract {

class NearLabels {
 public:
  struct Entry {
    std::int64_t label;
    NearChunks near;
    std::uint64_t rows = 0;  // the rows of corners that have voxels of the label around them, as bits by chunk_row()
  };

  NearLabels(const LabelChunks& labels, const glm::ivec3& origin);

  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

  // Calls f(entry, corner_words()) for the labels that have voxels around the corners of a row.
  template <class F>
  void for_each_in_row(int y, int z, const F& f) const {
    for (const Entry& entry : entries_) {
      if ((entry.rows >> chunk_row(y, z) & 1) != 0) f(entry, corner_words(entry.near, y, z));
    }
  }

  // Returns a bit for each corner of a row that has at least two labels around it. Voxels without a label count as one
  // more label.
  [[nodiscard]] std::uint64_t corners_between_labels(int y, int z) const;

 private:
  void put(const LabelChunk& chunk, int n);

  std::vector<Entry> entries_;
};

// Separates voxels without a label from voxels beyond the data boundary, around the corners of a chunk.
class NearRest {
 public:
  NearRest(const LabelChunks& labels, const NearLabels& near, const glm::ivec3& origin);

  // Returns the voxels without a label, then the voxels beyond the data boundary.
  [[nodiscard]] std::array<NearChunks, 2> near() const;

 private:
  std::array<ChunkBits, 8> unlabeled_{};
  std::array<ChunkBits, 8> beyond_{};
};

}  // namespace isoextract::extract
