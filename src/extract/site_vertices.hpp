// Numbers the vertices on the crossed edges of sparse samples, site by site. A site is a brick of 8x8x8 samples that
// owns crossed edges: those whose lower end is one of its samples (sparse_sites.hpp). Vertex numbers rise with the
// site, then the direction, then the sample.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <utility>

#include "base/buffer.hpp"
#include "extract/sparse_blocks.hpp"

namespace isoextract::extract {

class SiteVertices {
 public:
  SiteVertices() = default;
  // Starts with no crossed edges.
  SiteVertices(std::size_t sites, std::size_t directions) : directions_(directions), edges_(sites * directions) {
    for (Edges& edges : edges_) edges = {};
  }

  // Returns the bytes that the constructor allocates.
  [[nodiscard]] static std::uint64_t bytes(std::size_t sites, std::size_t directions) {
    return std::uint64_t{sites} * directions * sizeof(Edges);
  }
  // Returns the crossed edges of a site in one direction (an index into CaseTable::directions), one bit a sample.
  [[nodiscard]] BlockBits& crossed(std::size_t site, std::size_t direction) {
    return edges_[site * directions_ + direction].crossed;
  }
  [[nodiscard]] const BlockBits& crossed(std::size_t site, std::size_t direction) const {
    return edges_[site * directions_ + direction].crossed;
  }
  [[nodiscard]] bool is_crossed(std::size_t site, std::size_t direction, int offset) const {
    return (crossed(site, direction)[static_cast<std::size_t>(offset >> 6)] >> (offset & 63) & 1) != 0;
  }

  // Counts the crossed edges of a site; call it once they are all set.
  void count(std::size_t site) {
    for (std::size_t direction = 0; direction < directions_; ++direction) {
      Edges& edges = edges_[site * directions_ + direction];
      std::uint16_t total = 0;
      for (std::size_t x = 0; x < edges.crossed.size(); ++x) {
        edges.before[x] = total;
        total = static_cast<std::uint16_t>(total + std::popcount(edges.crossed[x]));
      }
      edges.first = total;
    }
  }

  // Numbers the vertices and returns their count; call it once all sites are counted.
  std::uint64_t number() {
    std::uint64_t total = 0;
    for (Edges& edges : edges_) total += std::exchange(edges.first, static_cast<std::uint32_t>(total));
    return total;
  }

  // Returns the number of the first vertex of a site in that direction.
  [[nodiscard]] std::uint32_t first(std::size_t site, std::size_t direction) const {
    return edges_[site * directions_ + direction].first;
  }

  // Returns the number of the vertex on a crossed edge; `offset` is field::block_offset() of its lower sample.
  [[nodiscard]] std::uint32_t at(std::size_t site, std::size_t direction, int offset) const {
    const Edges& edges = edges_[site * directions_ + direction];
    const auto x = static_cast<std::size_t>(offset >> 6);
    const std::uint64_t below = edges.crossed[x] & ((std::uint64_t{1} << (offset & 63)) - 1);
    return edges.first + edges.before[x] + static_cast<std::uint32_t>(std::popcount(below));
  }

 private:
  // The edges of one site and direction.
  struct Edges {
    BlockBits crossed;
    std::array<std::uint16_t, 8> before;  // number of crossed edges in earlier words
    std::uint32_t first;                  // before number(): count of the edges; then: number of the first vertex
  };

  std::size_t directions_ = 0;
  Buffer<Edges> edges_;
};

}  // namespace isoextract::extract
