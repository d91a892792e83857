#include "mesh/vertex_fans.hpp"

#include <algorithm>
#include <limits>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace isoextract::mesh {
namespace {

// A corner of a triangle: 3 * triangle + 0, 1 or 2.
using Corner = std::uint64_t;

std::uint32_t& vertex_of(Mesh& mesh, Corner corner) { return mesh.triangles[corner / 3][static_cast<int>(corner % 3)]; }

// The corners at each vertex, in rising order.
class CornersOfVertices {
 public:
  explicit CornersOfVertices(Mesh& mesh) : first_(mesh.positions.size() + 1, 0), corners_(3 * mesh.triangles.size()) {
    for (Corner c = 0; c < corners_.size(); ++c) ++first_[vertex_of(mesh, c) + 1];
    for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    std::vector<std::uint64_t> next(first_.begin(), first_.end() - 1);
    for (Corner c = 0; c < corners_.size(); ++c) corners_[next[vertex_of(mesh, c)]++] = c;
  }

  [[nodiscard]] std::span<const Corner> at(std::size_t vertex) const {
    return std::span(corners_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

  static std::uint64_t bytes(const Mesh& mesh) {
    return sizeof(std::uint64_t) * (2 * mesh.positions.size() + 3 * mesh.triangles.size());
  }

 private:
  std::vector<std::uint64_t> first_;
  std::vector<Corner> corners_;
};

// The two other vertices of a corner's triangle.
std::pair<std::uint32_t, std::uint32_t> others(Mesh& mesh, Corner corner) {
  const Corner first = corner - corner % 3;
  return {vertex_of(mesh, first + (corner + 1) % 3), vertex_of(mesh, first + (corner + 2) % 3)};
}

// Numbers the fans of one vertex: fan[i] for corners[i]. Returns how many there are. Vertices have few corners, hence
// the search through all of them.
std::uint32_t number_fans(Mesh& mesh, std::span<const Corner> corners, std::vector<std::uint32_t>& fan) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  fan.assign(corners.size(), kNone);
  std::uint32_t fans = 0;
  std::vector<std::size_t> reached;
  for (std::size_t start = 0; start < corners.size(); ++start) {
    if (fan[start] != kNone) continue;
    fan[start] = fans;
    reached.assign(1, start);
    while (!reached.empty()) {
      const auto [a, b] = others(mesh, corners[reached.back()]);
      reached.pop_back();
      for (std::size_t i = 0; i < corners.size(); ++i) {
        if (fan[i] != kNone) continue;
        const auto [c, d] = others(mesh, corners[i]);
        if (a != c && a != d && b != c && b != d) continue;
        fan[i] = fans;
        reached.push_back(i);
      }
    }
    ++fans;
  }
  return fans;
}

Result<void> part_fans(Mesh& mesh, const std::string& source) {
  const CornersOfVertices corners(mesh);
  std::vector<std::uint32_t> fan;
  Buffer<glm::uvec3> triangles(mesh.triangles.size());  // with the new numbers; the old ones tell the fans
  std::vector<std::uint32_t> source_of;                 // the old vertex of each new one
  source_of.reserve(mesh.positions.size());
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const auto at = corners.at(v);
    const std::uint32_t fans = number_fans(mesh, at, fan);
    if (source_of.size() + fans > std::numeric_limits<std::uint32_t>::max()) {
      return fail(ErrorKind::input, fmt::format("{}: the surface has more vertices than a mesh can number", source),
                  Remedy::extract_part);
    }
    const auto first = static_cast<std::uint32_t>(source_of.size());
    for (std::size_t i = 0; i < at.size(); ++i) {
      triangles[at[i] / 3][static_cast<int>(at[i] % 3)] = first + fan[i];
    }
    source_of.insert(source_of.end(), fans, v);
  }

  gather_vertices(mesh, source_of);
  mesh.triangles = std::move(triangles);
  return {};
}

}  // namespace

Result<void> make_one_vertex_a_fan(Mesh& mesh, const std::string& source, const Context& context) {
  const std::uint64_t bytes = CornersOfVertices::bytes(mesh) + 2 * mesh.positions.size() * vertex_bytes(mesh) +
                              mesh.triangles.size_bytes() + mesh.positions.size() * sizeof(std::uint32_t);
  const std::string what = fmt::format("{}: the holes of its surface", source);
  const auto memory = context.reserve(bytes, what);
  if (!memory) return tl::unexpected(memory.error());
  try {
    return part_fans(mesh, source);
  } catch (const std::bad_alloc&) {
    return fail(ErrorKind::input, fmt::format("{} need more memory than there is", what), Remedy::extract_part);
  }
}

}  // namespace isoextract::mesh
