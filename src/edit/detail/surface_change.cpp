#include "edit/detail/surface_change.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "mesh/greatest_distance.hpp"
#include "mesh/metrics.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::edit {
namespace {

// Triangles with three positions each.
struct NearSurface {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<char> unchanged;

  static constexpr std::uint64_t kTriangleBytes = 3 * sizeof(glm::vec3) + sizeof(glm::uvec3) + 1;

  void add(const std::array<glm::dvec3, 3>& corners, bool is_changed) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    triangles.emplace_back(first, first + 1, first + 2);
    for (const glm::dvec3& corner : corners) positions.emplace_back(corner);
    unchanged.push_back(is_changed ? 0 : 1);
  }
};

}  // namespace

Result<double> bound_surface_change(std::span<const glm::vec3> old_positions, std::span<const glm::uvec3> old_triangles,
                                    const mesh::Mesh& mesh, const glm::dmat3& to_metric, const Context& context) {
  const auto positions = std::as_const(mesh.positions).span();
  const auto is_changed = [&](std::size_t t) {
    if (t >= old_triangles.size() || mesh.triangles[t] != old_triangles[t]) return true;
    const glm::uvec3& c = old_triangles[t];
    return positions[c.x] != old_positions[c.x] || positions[c.y] != old_positions[c.y] ||
           positions[c.z] != old_positions[c.z];
  };
  std::vector<char> near(positions.size(), 0);  // 1: a changed triangle has or had this vertex
  std::uint64_t changed = 0;
  const auto mark = [&](const glm::uvec3& t) { near[t.x] = near[t.y] = near[t.z] = 1; };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!is_changed(t)) continue;
    ++changed;
    mark(mesh.triangles[t]);
    if (t < old_triangles.size()) mark(old_triangles[t]);
  }
  if (changed == 0) return 0.0;
  const auto is_near = [&](const glm::uvec3& t) { return (near[t.x] | near[t.y] | near[t.z]) != 0; };
  const auto count = static_cast<std::uint64_t>(std::ranges::count_if(mesh.triangles, is_near)) + changed;
  const auto memory =
      TRY(context.reserve(near.size() + 2 * count * NearSurface::kTriangleBytes + mesh::TriangleTree::bytes(count) +
                              mesh::GreatestDistanceSearch::bytes(3 * count, count),
                          mesh.name + ": the distance of the changed triangles"));
  const glm::dvec3 middle(positions[mesh.triangles[0].x]);
  const auto placed = [&](std::span<const glm::vec3> from, const glm::uvec3& t) {
    return std::array{to_metric * (glm::dvec3(from[t.x]) - middle), to_metric * (glm::dvec3(from[t.y]) - middle),
                      to_metric * (glm::dvec3(from[t.z]) - middle)};
  };
  NearSurface before;
  NearSurface after;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const bool is_new = is_changed(t);
    if (is_near(mesh.triangles[t])) after.add(placed(positions, mesh.triangles[t]), is_new);
    if (t < old_triangles.size() && is_near(old_triangles[t]))
      before.add(placed(old_positions, old_triangles[t]), is_new);
  }
  const double rounding = mesh::float32_resolution(before.positions) + mesh::float32_resolution(after.positions);
  double upper = 0;
  for (const auto& [from, to] : {std::pair(&before, &after), std::pair(&after, &before)}) {
    const mesh::TriangleTree tree(to->positions, to->triangles);
    mesh::GreatestDistanceSearch search({from->positions, from->triangles, from->unchanged}, tree, {.floor = rounding},
                                        context);
    search.measure_corners();
    upper = std::max(upper, search.bound_triangles().upper);
  }
  TRY(context.check());
  return upper + 2 * rounding;
}

}  // namespace isoextract::edit
