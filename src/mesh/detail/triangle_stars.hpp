// Stars: sets of very many triangles around one corner or one side.
//
// All boxes around such a place overlap, though few triangles do. Two triangles with a common corner have more in
// common only if they share a direction from that corner. Two triangles with a common side have more in common only if
// they lie in one half plane from this side. So boxes of directions separate them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "mesh/box_tree.hpp"

namespace isoextract::mesh {

class CrowdedStars {
 public:
  static constexpr std::uint32_t kNone = ~0U;
  // The corner or side of a star has more triangles than this; some of them may belong to other stars.
  static constexpr std::uint32_t kFewTriangles = 64;

  // `chosen` are ascending numbers of triangles with area. place_of(triangle) gives the places of its corners, as
  // vertex numbers: corners at the same position have the same number. Assigns each triangle to at most one
  // star: around its fullest side, or else its fullest corner. Throws std::bad_alloc.
  template <class PlaceOf>
  CrowdedStars(std::span<const glm::vec3> positions, std::span<const std::uint32_t> chosen, const PlaceOf& place_of)
      : positions_(positions) {
    const std::vector<std::uint32_t> counts = count_places(chosen, place_of);
    std::vector<Sides> crowded;
    for (const std::uint32_t triangle : chosen) {
      const glm::uvec3 places = place_of(triangle);
      if (is_in_star(places, counts)) crowded.push_back({places, triangle});
    }
    if (!crowded.empty()) make(crowded, counts, chosen.back() + std::size_t{1});
  }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t vertices) { return vertices * sizeof(std::uint32_t); }
  // Returns the additional bytes if there are stars.
  [[nodiscard]] static std::uint64_t crowded_bytes(std::uint64_t triangles) {
    return triangles * (sizeof(std::uint32_t) + 2 * sizeof(Sides) + 3 * sizeof(std::uint64_t));
  }

  [[nodiscard]] bool empty() const { return stars_.empty(); }
  [[nodiscard]] std::uint32_t star_of(std::uint32_t triangle) const { return stars_.empty() ? kNone : of_[triangle]; }
  // Returns the star of each triangle; empty if there are no stars.
  [[nodiscard]] std::span<const std::uint32_t> of_triangles() const { return of_.span(); }

  // Returns a box around the directions from the middle of the star to the points of the triangle. For a side, the box
  // is around the triangle's normal, turned so that equal normals mean one half plane from the side. Triangles of one
  // star whose boxes do not overlap share only their corner or side.
  [[nodiscard]] FloatBox directions(std::uint32_t star, const glm::uvec3& corners) const;

  // Returns a box of the directions in which the star's middle sees `box`; for a side, all directions.
  [[nodiscard]] FloatBox seen(std::uint32_t star, const FloatBox& box) const;

 private:
  struct Star {
    std::uint32_t middle;  // a place (vertex number)
    std::uint32_t end;     // other end of the side; kNone around a corner
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
  static bool is_in_star(const glm::uvec3& places, const std::vector<std::uint32_t>& counts) {
    return counts[places.x] > kFewTriangles || counts[places.y] > kFewTriangles || counts[places.z] > kFewTriangles;
  }
  void make(const std::vector<Sides>& crowded, const std::vector<std::uint32_t>& counts, std::size_t triangles);

  std::span<const glm::vec3> positions_;
  std::vector<Star> stars_;
  Buffer<std::uint32_t> of_;  // the star of each triangle
};

}  // namespace isoextract::mesh
