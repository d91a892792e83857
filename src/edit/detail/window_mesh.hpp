// The part of a mesh that a window of simplify_windows.hpp holds, and intervals along the axis of the windows.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/mesh.hpp"

namespace isoextract::edit {

inline constexpr double kEverywhere = std::numeric_limits<double>::infinity();

struct Interval {
  double low = kEverywhere;
  double high = -kEverywhere;

  void add(const Interval& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
  [[nodiscard]] Interval widened(double by) const { return {low - by, high + by}; }
  [[nodiscard]] bool meets(const Interval& other) const { return low <= other.high && other.low <= high; }
  [[nodiscard]] bool contains(const Interval& other) const { return low <= other.low && other.high <= high; }
};

// Numbers a subset of the vertices in ascending order.
class VertexNumbers {
 public:
  explicit VertexNumbers(std::size_t vertices) : bits_((vertices + 63) / 64, 0), before_(bits_.size(), 0) {}

  void add(const glm::uvec3& t) {
    for (const std::uint32_t v : {t.x, t.y, t.z}) bits_[v / 64] |= std::uint64_t{1} << (v % 64);
  }
  // Call it after the last add(). Returns the vertices.
  [[nodiscard]] std::vector<std::uint32_t> list() {
    std::vector<std::uint32_t> vertices;
    for (std::size_t word = 0; word < bits_.size(); ++word) {
      before_[word] = static_cast<std::uint32_t>(vertices.size());
      for (std::uint64_t rest = bits_[word]; rest != 0; rest &= rest - 1) {
        vertices.push_back(static_cast<std::uint32_t>(64 * word + static_cast<std::size_t>(std::countr_zero(rest))));
      }
    }
    return vertices;
  }
  [[nodiscard]] std::uint32_t of(std::uint32_t v) const {
    const std::uint64_t lower = (std::uint64_t{1} << (v % 64)) - 1;
    return before_[v / 64] + static_cast<std::uint32_t>(std::popcount(bits_[v / 64] & lower));
  }
  [[nodiscard]] glm::uvec3 of(const glm::uvec3& t) const { return {of(t.x), of(t.y), of(t.z)}; }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t vertices) { return vertices / 4; }

 private:
  std::vector<std::uint64_t> bits_;
  std::vector<std::uint32_t> before_;  // vertices of the subset before each word of bits_
};

// The triangles and vertices of a window, with their numbers in the whole mesh. All lists are ascending.
struct Window {
  std::vector<std::uint32_t> originals;  // triangles whose originals the window has
  std::vector<std::uint32_t> present;    // triangles as they are now
  std::vector<std::uint32_t> triangles;  // both
  std::vector<std::uint32_t> vertices;
  std::optional<VertexNumbers> numbers;  // of `vertices`
  mesh::Mesh original;
  std::vector<glm::uvec3> corners;
  std::vector<char> gone, not_original, locked, wanted;  // as in CollapseStart
  std::vector<std::int8_t> sides;

  static constexpr std::uint64_t kTriangleBytes = 4 * sizeof(std::uint32_t) + 2 * sizeof(glm::uvec3) + 2;
  static constexpr std::uint64_t kVertexBytes = sizeof(std::uint32_t) + sizeof(glm::vec3) + 3;
};

}  // namespace isoextract::edit
