// Numbers of the points of a surface net: one for each voxel corner with more than one label around it.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "extract/detail/label_chunks.hpp"
#include "extract/detail/net_memory.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {

class NetGrid {
 public:
  // The points of a row: the 64 corners along x at one y and z in a chunk.
  struct Row {
    std::uint64_t used = 0;   // the corners that have a point
    std::uint32_t first = 0;  // the number of the first of these points

    // Returns the number of the point at a corner that has one.
    [[nodiscard]] std::uint32_t number(int bit) const {
      return first + static_cast<std::uint32_t>(count_bits(used & ((std::uint64_t{1} << bit) - 1)));
    }
  };

  // Fails if memory runs out, if the context is cancelled, and with ErrorCode::input if 32-bit numbers do not suffice.
  [[nodiscard]] static Result<NetGrid> make(const LabelChunks& labels, NetMemory& memory);

  // Returns the bytes of the numbers in so many chunks that have points.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t chunks) { return index_bytes(chunks) + array_bytes(chunks); }
  // Returns the part of bytes() that NetMemory may put into files.
  [[nodiscard]] static std::uint64_t array_bytes(std::uint64_t chunks) {
    return chunks * (sizeof(NearChunkNumbers) + sizeof(ChunkBits) + sizeof(RowBases));
  }

  // Returns whether these go to files: the arrays of the points, known only later, usually take three times as much.
  [[nodiscard]] static bool prefers_files(std::uint64_t chunks, const Context& context) {
    return NetMemory::prefers_files(4 * array_bytes(chunks), context);
  }

  [[nodiscard]] std::uint64_t size() const { return points_; }
  // Returns the chunks that have points, in chunk_order().
  [[nodiscard]] const std::vector<glm::ivec3>& origins() const { return origins_; }
  // Returns the number of the chunk at `origin`; negative if it has no points.
  [[nodiscard]] std::int32_t find(const glm::ivec3& origin) const { return index_.find(origin); }

  // The numbers of a chunk and its 26 neighbors. The chunk at steps (x, y, z), each from -1 to 1, has the index
  // x + 3 y + 9 z + 13. A chunk without points has a negative number.
  using NearChunkNumbers = std::array<std::int32_t, 27>;
  [[nodiscard]] const NearChunkNumbers& near(std::size_t chunk) const { return near_[chunk]; }

  // Returns a row of a chunk; an empty row if `chunk` is negative.
  [[nodiscard]] Row row(std::int32_t chunk, int y, int z) const {
    if (chunk < 0) return {};
    const auto c = static_cast<std::size_t>(chunk);
    return {used_[c][chunk_row(y, z)], first_[c][chunk_row(y, z)]};
  }

  // Calls f(row, y, z) for the rows of a chunk that have points.
  template <class F>
  void for_each_row(std::size_t chunk, const F& f) const {
    for (int z = 0; z < 8; ++z) {
      for (int y = 0; y < 8; ++y) {
        const Row found = row(static_cast<std::int32_t>(chunk), y, z);
        if (found.used != 0) f(found, y, z);
      }
    }
  }

  // Returns the numbers of the points of a chunk, as a half-open range.
  [[nodiscard]] std::pair<std::size_t, std::size_t> points(std::size_t chunk) const {
    return {first_[chunk][0], chunk + 1 < first_.size() ? first_[chunk + 1][0] : points_};
  }

 private:
  using RowBases = std::array<std::uint32_t, 64>;

  [[nodiscard]] static std::uint64_t index_bytes(std::uint64_t chunks) {
    return VoxelChunks::bytes(chunks) + chunks * sizeof(glm::ivec3);
  }

  std::vector<glm::ivec3> origins_;
  field::OriginIndex index_;
  NetArray<NearChunkNumbers> near_;
  NetArray<ChunkBits> used_;
  NetArray<RowBases> first_;  // number of the first point of each row
  std::uint64_t points_ = 0;
  Reservation memory_;
};

}  // namespace isoextract::extract
