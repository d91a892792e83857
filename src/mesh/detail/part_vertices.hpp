// Vertices of one part of a mesh, numbered without gaps for arrays of the part's size.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/parallel.hpp"

namespace isoextract::mesh {

// The triangles of a part with local vertex numbers, from 0 on: first the vertices of this part and of the next part,
// then, if the part is a cap, all far vertices (MeshShape::far_vertices).
class PartVertices {
 public:
  // Expects that the caller has reserved bytes(). `far` must outlive the object. Throws std::bad_alloc.
  PartVertices(std::span<const glm::uvec3> triangles, std::uint64_t first_vertex, std::span<const std::uint32_t> far)
      : first_(first_vertex), far_(far), triangles_(triangles.size()) {
    struct Range {
      std::uint32_t least = 0xFFFFFFFF;
      std::uint32_t most = 0;
    };
    const Range range = reduce_ranges(
        triangles.size(), kGrain, Range(),
        [&](std::size_t begin, std::size_t end, Range found) {
          for (const glm::uvec3& t : triangles.subspan(begin, end - begin)) {
            found.least = std::min({found.least, t.x, t.y, t.z});
            found.most = std::max({found.most, t.x, t.y, t.z});
          }
          return found;
        },
        [](const Range& a, const Range& b) {
          return Range{std::min(a.least, b.least), std::max(a.most, b.most)};
        });
    near_ = !triangles.empty() && range.most >= first_ ? range.most - first_ + 1 : 0;
    has_far_ = !triangles.empty() && range.least < first_;
    for_each_range(triangles.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t != end; ++t) {
        for (int corner = 0; corner < 3; ++corner) triangles_[t][corner] = local(triangles[t][corner]);
      }
    });
  }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t triangles) { return triangles * sizeof(glm::uvec3); }

  [[nodiscard]] std::span<const glm::uvec3> triangles() const { return triangles_.span(); }
  // Returns the count of local numbers.
  [[nodiscard]] std::size_t size() const { return near_ + (has_far_ ? far_.size() : 0); }
  // Returns the count of local numbers for vertices of this part and of the next part.
  [[nodiscard]] std::size_t near() const { return near_; }
  [[nodiscard]] bool has_far() const { return has_far_; }
  [[nodiscard]] std::uint32_t global(std::size_t number) const {
    return number < near_ ? static_cast<std::uint32_t>(first_ + number) : far_[number - near_];
  }

 private:
  static constexpr std::size_t kGrain = 1 << 14;

  [[nodiscard]] std::uint32_t local(std::uint32_t vertex) const {
    if (vertex >= first_) return static_cast<std::uint32_t>(vertex - first_);
    return static_cast<std::uint32_t>(near_ + (std::ranges::lower_bound(far_, vertex) - far_.begin()));
  }

  std::uint64_t first_;
  std::span<const std::uint32_t> far_;
  std::size_t near_ = 0;
  bool has_far_ = false;
  Buffer<glm::uvec3> triangles_;
};

}  // namespace isoextract::mesh
