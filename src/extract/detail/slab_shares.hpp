// Slabs of one volume on several ranks (base/ranks.hpp). Each rank has consecutive slabs.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "base/error.hpp"
#include "base/packed_values.hpp"
#include "base/ranks.hpp"
#include "extract/dense_masks.hpp"
#include "extract/detail/row_table.hpp"
#include "extract/mesh_assembly.hpp"

namespace isoextract::extract {

struct SlabRange {
  int begin = 0;
  int end = 0;

  [[nodiscard]] int count() const { return end - begin; }
};

// Returns the slabs of this rank; all slabs if `ranks` is null.
[[nodiscard]] inline SlabRange own_slabs(int slabs, const Ranks* ranks) {
  if (ranks == nullptr) return {0, slabs};
  const auto part = [&](int rank) { return static_cast<int>(static_cast<std::int64_t>(slabs) * rank / ranks->size()); };
  return {part(ranks->rank()), part(ranks->rank() + 1)};
}

// Returns the slices [begin, end) of a rank, and its vertices that the rank before uses. The region of the field, whose
// rows have been placed, begins with slice `first` of the field.
[[nodiscard]] inline RankSlices slices_of_rank(Ranks& ranks, int begin, int end, int first, const RowTable& rows) {
  RankSlices slices{&ranks, first + begin, first + end};
  if (begin == 0 || begin == end) return slices;
  slices.first_shared_vertex = rows.vertices(rows.index(0, begin))[0];
  slices.shared_vertices = rows.vertices(rows.index(0, begin + 1))[0] - slices.first_shared_vertex;
  return slices;
}

// The counts of one rank, or the sum over several ranks.
struct SlabCounts {
  MeshSizes sizes;
  std::uint64_t bricks_crossed = 0;
  SliceSides sides;

  void add(const SlabCounts& other) {
    sizes.vertices += other.sizes.vertices;
    sizes.triangles += other.sizes.triangles;
    bricks_crossed += other.bricks_crossed;
    sides.add(other.sides);
  }
};

struct SharedCounts {
  SlabCounts before;  // of the ranks before this one
  SlabCounts all;
};

// Sums the counts of all ranks. Every rank must call this function, with its own counts. Fails as Ranks::gather() does.
[[nodiscard]] inline Result<SharedCounts> share_counts(const SlabCounts& own, Ranks& ranks) {
  const auto told = TRY(ranks.gather(Packer().put(own).take()));
  SharedCounts counts;
  for (int r = 0; r < ranks.size(); ++r) {
    if (r == ranks.rank()) counts.before = counts.all;
    counts.all.add(Unpacker(told[static_cast<std::size_t>(r)]).get<SlabCounts>());
  }
  return counts;
}

}  // namespace isoextract::extract
