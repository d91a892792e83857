// The number of the first vertex and the first triangle of each row of samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/parallel.hpp"
#include "extract/mesh_assembly.hpp"

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

  // Sums the counts, so that counted_below() is valid.
  void sum() {
    below_.assign(slices_ + 1, {});
    for_each_index(slices_, [&](std::size_t k) {
      const auto vertex_counts = vertices_.span().subspan(k * rows_ * directions_, rows_ * directions_);
      const auto triangle_counts = triangles_.span().subspan(k * rows_, rows_);
      below_[k] = {std::accumulate(vertex_counts.begin(), vertex_counts.end(), std::uint64_t{0}),
                   std::accumulate(triangle_counts.begin(), triangle_counts.end(), std::uint64_t{0})};
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

 private:
  std::size_t rows_;
  std::size_t directions_;
  int first_slice_;
  std::size_t slices_;
  Buffer<std::uint32_t> vertices_;   // per row and direction
  Buffer<std::uint64_t> triangles_;  // per row
  std::vector<MeshSizes> below_;
};

}  // namespace isoextract::extract
