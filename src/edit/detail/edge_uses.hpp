// The triangles at each edge of a mesh, sorted by edge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::edit {

// A side of a triangle: `side` 0 runs from corner 0 to corner 1, and so on.
struct EdgeUse {
  std::uint32_t low = 0;  // the smaller vertex
  std::uint32_t high = 0;
  std::uint32_t triangle = 0;
  std::uint8_t side = 0;
  bool rising = false;  // the triangle runs from `low` to `high`

  [[nodiscard]] std::uint32_t from() const { return rising ? low : high; }
  [[nodiscard]] std::uint32_t to() const { return rising ? high : low; }
};

// Triangles that repeat an index have no edges. The caller reserves bytes(). Throws std::bad_alloc.
class EdgeUses {
 public:
  explicit EdgeUses(std::span<const glm::uvec3> triangles);

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t triangles) { return 3 * triangles * sizeof(EdgeUse); }

  // Returns the uses of an edge; empty if no triangle has it.
  [[nodiscard]] std::span<const EdgeUse> of_edge(std::uint32_t a, std::uint32_t b) const;

  // Calls visit(uses) for each edge, in the order of the vertices.
  template <class Visit>
  void for_each_edge(const Visit& visit) const {
    for (std::size_t begin = 0; begin < uses_.size();) {
      std::size_t end = begin + 1;
      while (end < uses_.size() && uses_[end].low == uses_[begin].low && uses_[end].high == uses_[begin].high) ++end;
      visit(std::span<const EdgeUse>(uses_).subspan(begin, end - begin));
      begin = end;
    }
  }

 private:
  std::vector<EdgeUse> uses_;
};

}  // namespace isoextract::edit
