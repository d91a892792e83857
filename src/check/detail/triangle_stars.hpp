// Triangles that have a corner, or a side, in common with very many others.
//
// Around such a place the boxes of all of them meet, though few of the triangles do. Two triangles with a corner in
// common have more in common only if they have a direction from that corner in common; two with a side, only if they
// are on the same side of it in one plane. So boxes of directions tell them apart.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "mesh/box_tree.hpp"

namespace isoextract::check {

using mesh::FloatBox;

class TriangleStars {
 public:
  static constexpr std::uint32_t kNone = ~0U;
  // A star has more triangles than this.
  static constexpr std::uint32_t kFewTriangles = 64;

  // `chosen` are numbers of triangles that have area, in rising order; place_of(triangle) gives the places of its
  // corners, each below positions.size() and the number of a vertex there. A triangle is in one star at most: around
  // its fullest side, or else its fullest corner. Throws std::bad_alloc.
  template <class PlaceOf>
  TriangleStars(std::span<const glm::vec3> positions, std::span<const std::uint32_t> chosen, const PlaceOf& place_of)
      : positions_(positions) {
    const std::vector<std::uint32_t> counts = count_places(chosen, place_of);
    std::vector<Sides> crowded;
    for (const std::uint32_t triangle : chosen) {
      const glm::uvec3 places = place_of(triangle);
      if (is_crowded(places, counts)) crowded.push_back({places, triangle});
    }
    if (!crowded.empty()) make(crowded, counts, chosen.back() + std::size_t{1});
  }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t vertices) { return vertices * sizeof(std::uint32_t); }
  // What it takes more where it is not empty.
  [[nodiscard]] static std::uint64_t crowded_bytes(std::uint64_t triangles) {
    return triangles * (sizeof(std::uint32_t) + 2 * sizeof(Sides) + 3 * sizeof(std::uint64_t));
  }

  [[nodiscard]] bool empty() const { return stars_.empty(); }
  [[nodiscard]] std::uint32_t star_of(std::uint32_t triangle) const { return stars_.empty() ? kNone : of_[triangle]; }
  // The star of each triangle; nothing where there are none.
  [[nodiscard]] std::span<const std::uint32_t> of_triangles() const { return of_.span(); }

  // A box of the directions from the middle of the star in which a triangle of it lies; around a side, across it.
  // Triangles of one star whose boxes do not meet have nothing in common but their corner or side.
  [[nodiscard]] FloatBox directions(std::uint32_t star, const glm::uvec3& corners) const;

  // A box of the directions in which a box is seen from the middle of the star; all around a side.
  [[nodiscard]] FloatBox seen(std::uint32_t star, const FloatBox& box) const;

 private:
  struct Star {
    std::uint32_t middle;  // a place
    std::uint32_t end;     // of the side; kNone around a corner
  };
  struct Sides {
    glm::uvec3 places;
    std::uint32_t triangle;
  };
  template <class PlaceOf>
  std::vector<std::uint32_t> count_places(std::span<const std::uint32_t> chosen, const PlaceOf& place_of) const {
    std::vector<std::uint32_t> counts(positions_.size(), 0);
    for (const std::uint32_t triangle : chosen) {
      const glm::uvec3 places = place_of(triangle);
      for (int corner = 0; corner < 3; ++corner) ++counts[places[corner]];
    }
    return counts;
  }
  static bool is_crowded(const glm::uvec3& places, const std::vector<std::uint32_t>& counts) {
    return counts[places.x] > kFewTriangles || counts[places.y] > kFewTriangles || counts[places.z] > kFewTriangles;
  }
  void make(const std::vector<Sides>& crowded, const std::vector<std::uint32_t>& counts, std::size_t triangles);

  std::span<const glm::vec3> positions_;
  std::vector<Star> stars_;
  Buffer<std::uint32_t> of_;  // of each triangle: its star
};

}  // namespace isoextract::check
