#include "accuracy/detail/surface_to_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "accuracy/surface_coverage.hpp"

namespace isoextract::accuracy {

SurfaceToMesh::SurfaceToMesh(const mesh::Mesh& mesh, const mesh::TriangleTree* tree, const IndexMesh& placed,
                             std::span<const mesh::HalfSpace> clipped, const SearchWindow& window)
    : tree_(tree),
      placed_(placed),
      window_(window),
      clipped_(clipped),
      linear_(placed.output_from_index().linear),
      inverse_(glm::inverse(linear_)),
      origin_(mesh.origin),
      offset_(placed.output_from_index().offset - mesh.origin) {}

mesh::TriangleTree::Nearest SurfaceToMesh::add(const glm::dvec3& index, double weight, std::uint32_t hint,
                                               SurfaceToMeshSums& sums) const {
  const glm::dvec3 p = to_tree(index);
  const mesh::TriangleTree::Nearest nearest =
      tree_ != nullptr ? tree_->nearest(p, hint) : mesh::TriangleTree::Nearest();
  sums.needed = std::max(sums.needed, window_.needed(index, std::sqrt(nearest.distance_squared)));
  const glm::dvec3 world = placed_.output_from_index()(index);
  if (tree_ != nullptr && weight > 0 && is_kept(world, clipped_)) {
    sums.distances.add({glm::length(inverse_ * (nearest.point - p)), std::sqrt(nearest.distance_squared)}, weight,
                       world);
  }
  return nearest;
}

void SurfaceToMesh::clip(const std::array<glm::dvec3, 3>& triangle, std::vector<glm::dvec3>& polygon,
                         std::vector<glm::dvec3>& before) const {
  polygon.assign(triangle.begin(), triangle.end());
  for (const mesh::HalfSpace& space : clipped_) {
    polygon.swap(before);
    polygon.clear();
    for (std::size_t i = 0; i < before.size(); ++i) {
      const glm::dvec3& here = before[i];
      const glm::dvec3& next = before[(i + 1) % before.size()];
      const double depth = space.depth(here + origin_);
      const double next_depth = space.depth(next + origin_);
      if (depth >= 0) polygon.push_back(here);
      if ((depth >= 0) != (next_depth >= 0)) polygon.push_back(here + (next - here) * (depth / (depth - next_depth)));
    }
  }
}

void SurfaceToMesh::measure(const SubdividedSurface& surface, FieldFootFinder& foot, double reach,
                            const std::function<bool(const glm::dvec3& index)>& counts, SurfaceToMeshSums& sums) const {
  // Exact for polynomials of degree two: a twelfth of the area for each corner, the rest for the center.
  constexpr double kCornerShare = 1.0 / 12;
  constexpr double kCenterShare = 3.0 / 4;
  const mesh::Mesh& mesh = surface.mesh();
  std::vector<Sample> samples(mesh.positions.size());
  std::vector<std::uint32_t> counted;
  std::vector<glm::dvec3> polygon;
  std::vector<glm::dvec3> polygon_before;
  const auto corners_of = [&](const glm::uvec3& t) {
    return std::array{surface.index(glm::dvec3(mesh.positions[t.x])), surface.index(glm::dvec3(mesh.positions[t.y])),
                      surface.index(glm::dvec3(mesh.positions[t.z]))};
  };
  const auto center_of = [](const std::array<glm::dvec3, 3>& corners) {
    return (corners[0] + corners[1] + corners[2]) / 3.0;
  };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto corners = corners_of(mesh.triangles[t]);
    const glm::dvec3 center = center_of(corners);
    if (!counts(center)) continue;
    if (!clipped_.empty()) {
      clip({to_tree(corners[0]), to_tree(corners[1]), to_tree(corners[2])}, polygon, polygon_before);
      if (polygon.empty()) continue;  // none of its points counts
    }
    counted.push_back(t);
    const double area = glm::length(placed_.area_vector(corners)) / 2;
    for (int corner = 0; corner < 3; ++corner) {
      Sample& sample = samples[mesh.triangles[t][corner]];
      sample.weight += kCornerShare * area;
      sample.used = true;
    }
  }
  std::uint32_t hint = 0;
  for (std::size_t v = 0; v < samples.size(); ++v) {
    Sample& sample = samples[v];
    if (!sample.used) continue;
    const auto nearest = add(surface.index(glm::dvec3(mesh.positions[v])), sample.weight, hint, sums);
    sample.slot = hint = nearest.slot;
    sample.distance = std::sqrt(nearest.distance_squared);
  }
  if (tree_ == nullptr) return;
  for (const std::uint32_t t : counted) {
    const glm::uvec3& triangle = mesh.triangles[t];
    const auto corners = corners_of(triangle);
    const glm::dvec3 center = center_of(corners);
    const std::array places{to_tree(corners[0]), to_tree(corners[1]), to_tree(corners[2])};
    std::span<const glm::dvec3> kept = places;
    if (!clipped_.empty()) {
      clip(places, polygon, polygon_before);
      kept = polygon;
    }
    const bool center_is_kept = is_kept(placed_.output_from_index()(center), clipped_);
    const double area = glm::length(placed_.area_vector(corners)) / 2;
    const glm::dvec3 landed = foot.land(center, reach).value_or(center);
    const auto at_center = add(landed, center_is_kept ? kCenterShare * area : 0, samples[triangle.x].slot, sums);

    double longest = 0;
    double farthest = 0;  // largest distance of the corners
    for (int corner = 0; corner < 3; ++corner) {
      longest = std::max(longest, glm::length(places[(corner + 1) % 3] - places[corner]));
      farthest = std::max(farthest, samples[triangle[corner]].distance);
    }
    // No point of a triangle is farther than longest / sqrt(3) from the nearest corner.
    double bound = farthest + longest / std::sqrt(3.0);
    for (const std::uint32_t slot :
         {at_center.slot, samples[triangle.x].slot, samples[triangle.y].slot, samples[triangle.z].slot}) {
      bound = std::min(bound, std::sqrt(tree_->max_distance_squared(slot, kept)));
    }
    sums.at_most = std::max(sums.at_most, bound + foot.length(landed - center));
  }
}

}  // namespace isoextract::accuracy
