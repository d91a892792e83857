#include "mesh/adjacency.hpp"

#include <algorithm>
#include <utility>

namespace isoextract::mesh {

Adjacency::Adjacency(std::span<const glm::uvec3> triangles, std::size_t vertices)
    : corners_(triangles.size(), vertices, [&](std::size_t t, const auto& put) {
        for (int c = 0; c < 3; ++c) put(triangles[t][c], 3 * Corner{t} + static_cast<Corner>(c));
      }) {}

void VertexStar::look_at(std::span<const Corner> corners, std::span<const glm::uvec3> triangles) {
  sides_.clear();
  for (std::uint32_t i = 0; i < corners.size(); ++i) {
    const glm::uvec3& t = triangles[triangle_of(corners[i])];
    const auto c = static_cast<int>(corners[i] % 3);
    vertex_ = t[c];
    sides_.push_back({t[(c + 1) % 3], i, true});
    sides_.push_back({t[(c + 2) % 3], i, false});
  }
  std::sort(sides_.begin(), sides_.end(),
            [](const Side& a, const Side& b) { return std::pair(a.end, a.corner) < std::pair(b.end, b.corner); });
  fan_of_.resize(corners.size());
  number_fans();
}

// First builds disjoint sets of corners, each identified by its first corner.
void VertexStar::number_fans() {
  std::vector<std::uint32_t>& first = fan_of_;
  for (std::uint32_t i = 0; i < first.size(); ++i) first[i] = i;
  const auto find = [&](std::uint32_t i) {
    while (first[i] != i) i = first[i] = first[first[i]];
    return i;
  };
  for (std::size_t s = 1; s < sides_.size(); ++s) {
    if (sides_[s].end != sides_[s - 1].end) continue;
    const auto [low, high] = std::minmax({find(sides_[s - 1].corner), find(sides_[s].corner)});
    first[high] = low;
  }
  fans_ = 0;
  // The first corner of a set comes first, so its fan number is known when the other corners need it.
  for (std::uint32_t i = 0; i < first.size(); ++i) first[i] = first[i] == i ? fans_++ : first[first[i]];
}

bool VertexStar::is_closed_fan() const {
  if (fans_ != 1 || sides_.size() % 2 != 0) return false;
  for (std::size_t s = 0; s < sides_.size(); s += 2) {
    const Side& a = sides_[s];
    const Side& b = sides_[s + 1];
    if (a.end != b.end || a.outgoing == b.outgoing || a.end == vertex_) return false;
    if (s > 0 && sides_[s - 1].end == a.end) return false;
  }
  return true;
}

}  // namespace isoextract::mesh
