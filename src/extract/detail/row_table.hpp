// The number of the first vertex and the first triangle of each row of samples.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <type_traits>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/parallel.hpp"
#include "extract/detail/cell_rows.hpp"
#include "extract/detail/cell_streams.hpp"
#include "extract/mesh_assembly.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {

// Covers the rows of consecutive slices (planes of equal z). Holds the counts of each row until place() is called, then
// the numbers of its first vertices and first triangle.
class RowTable {
 public:
  // `rows` is the number of rows in a slice; `directions` is the number of edges that begin at a sample.
  RowTable(int rows, int directions, int first_slice, int end_slice)
      : rows_(static_cast<std::size_t>(rows)),
        directions_(static_cast<std::size_t>(directions)),
        first_slice_(first_slice),
        slices_(static_cast<std::size_t>(end_slice - first_slice)) {}

  [[nodiscard]] std::size_t rows() const { return rows_ * slices_; }
  // Returns the bytes of the vertex and the triangle table. Both have an additional row at the end.
  [[nodiscard]] std::size_t bytes() const {
    return (rows() + 1) * (directions_ * sizeof(std::uint32_t) + sizeof(std::uint64_t));
  }
  void allocate() {
    vertices_ = Buffer<std::uint32_t>((rows() + 1) * directions_);
    triangles_ = Buffer<std::uint64_t>(rows() + 1);
  }

  // Returns the index of row (j, k).
  [[nodiscard]] std::size_t index(int j, int k) const {
    return static_cast<std::size_t>(j) + rows_ * static_cast<std::size_t>(k - first_slice_);
  }
  // Returns the values of a row, by direction.
  [[nodiscard]] std::uint32_t* vertices(std::size_t row) { return vertices_.data() + row * directions_; }
  [[nodiscard]] const std::uint32_t* vertices(std::size_t row) const { return vertices_.data() + row * directions_; }
  [[nodiscard]] std::uint64_t& triangles(std::size_t row) { return triangles_[row]; }
  [[nodiscard]] const std::uint64_t& triangles(std::size_t row) const { return triangles_[row]; }

  // Returns the counted vertices of a row. Call before place(), as counted_in().
  [[nodiscard]] std::uint64_t counted_vertices(std::size_t row) const {
    return std::accumulate(vertices(row), vertices(row) + directions_, std::uint64_t{0});
  }
  // Returns the sizes of the slices from `begin` to end - 1.
  [[nodiscard]] MeshSizes counted_in(int begin, int end) const {
    MeshSizes sizes;
    for (std::size_t row = index(0, begin); row < index(0, end); ++row) {
      sizes.vertices += counted_vertices(row);
      sizes.triangles += triangles_[row];
    }
    return sizes;
  }

  // Sums the counts, so that counted_below() is valid.
  void sum() {
    below_.assign(slices_ + 1, {});
    for_each_index(slices_, [&](std::size_t k) {
      const int slice = first_slice_ + static_cast<int>(k);
      below_[k] = counted_in(slice, slice + 1);
    });
    MeshSizes sizes;
    for (MeshSizes& slice : below_) {
      sizes.vertices += std::exchange(slice.vertices, sizes.vertices);
      sizes.triangles += std::exchange(slice.triangles, sizes.triangles);
    }
  }
  // Returns the counts of the slices before slice `k`, which may be the end.
  [[nodiscard]] const MeshSizes& counted_below(int k) const {
    return below_[static_cast<std::size_t>(k - first_slice_)];
  }

  // Turns counts into numbers that begin with `first`. Call sum() first.
  void place(const MeshSizes& first) {
    for_each_index(slices_, [&](std::size_t k) {
      auto vertex = static_cast<std::uint32_t>(first.vertices + below_[k].vertices);
      for (std::uint32_t& base : vertices_.span().subspan(k * rows_ * directions_, rows_ * directions_)) {
        vertex += std::exchange(base, vertex);
      }
      std::uint64_t triangle = first.triangles + below_[k].triangles;
      for (std::uint64_t& base : triangles_.span().subspan(k * rows_, rows_)) {
        triangle += std::exchange(base, triangle);
      }
    });
    vertices(rows())[0] = static_cast<std::uint32_t>(first.vertices + below_.back().vertices);
    triangles_[rows()] = first.triangles + below_.back().triangles;
  }

  // Returns the numbers of the first vertex and triangle behind the slices before slice `k`, which may be the end. Call
  // after place().
  [[nodiscard]] MeshSizes numbers_at(int k) const {
    const std::size_t row = index(0, k);
    return {vertices(row)[0], triangles(row)};
  }

  // Returns the number of the first vertex of each stream of row (j, k), as CellStreams lists them. Call after place().
  [[nodiscard]] std::array<std::uint32_t, kMaxStreams> first_of_streams(int j, int k) const {
    return directions_ == 3 ? first_of_streams(j, k, std::integral_constant<int, 3>{})
                            : first_of_streams(j, k, std::integral_constant<int, 7>{});
  }

 private:
  template <int kDirections>
  [[nodiscard]] std::array<std::uint32_t, kMaxStreams> first_of_streams(
      int j, int k, std::integral_constant<int, kDirections> /*directions*/) const {
    std::array<std::uint32_t, kMaxStreams> first{};
    std::size_t s = 0;
    for (const auto& stream : kCellStreams<kDirections>.streams) {
      const std::size_t row = index(j + (stream.row & 1), k + (stream.row >> 1));
      first[s++] = vertices(row)[direction_index<kDirections>(stream.direction)];
    }
    return first;
  }

  std::size_t rows_;
  std::size_t directions_;
  int first_slice_;
  std::size_t slices_;
  Buffer<std::uint32_t> vertices_;   // per row and direction
  Buffer<std::uint64_t> triangles_;  // per row
  std::vector<MeshSizes> below_;
};

// Returns how many samples before `p` in its row have a crossed edge toward `direction`. mask_word(j, k, w) returns
// word `w` of the mask of row (j, k), zero behind the last.
template <class MaskWord>
[[nodiscard]] std::uint32_t crossed_edges_before(const glm::ivec3& p, int direction, const MaskWord& mask_word) {
  const glm::ivec3 upper = p + direction_step(direction & ~1);
  std::uint32_t count = 0;
  for (int w = 0; w <= p.x / 64; ++w) {
    const std::uint64_t here = mask_word(upper.y, upper.z, w);
    const std::uint64_t ends = (direction & 1) != 0 ? here >> 1U | mask_word(upper.y, upper.z, w + 1) << 63U : here;
    count += static_cast<std::uint32_t>(std::popcount((mask_word(p.y, p.z, w) ^ ends) & bits_below(w, p.x)));
  }
  return count;
}

}  // namespace isoextract::extract
