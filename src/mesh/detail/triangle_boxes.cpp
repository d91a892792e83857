#include "mesh/detail/triangle_boxes.hpp"

#include "base/parallel.hpp"

namespace isoextract::mesh {

TriangleBoxes::TriangleBoxes(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles,
                             std::span<const std::uint32_t> chosen, const CrowdedStars& stars)
    : positions_(positions), triangles_(triangles), stars_(stars), tree_(tree_of(*this, chosen)) {
  if (stars.empty()) return;
  directions_ = Buffer<Directions>(tree_.nodes());
  tree_.fit(directions_.span(), [&](std::uint32_t triangle) { return directions_of(triangle); });
}

// Uses only positions_, triangles_ and stars_: the constructor calls it before the other members exist.
BoxTree TriangleBoxes::tree_of(const TriangleBoxes& boxes, std::span<const std::uint32_t> chosen) {
  Buffer<BoxTree::Item> items(chosen.size());
  for_each_index(chosen.size(), [&](std::size_t i) { items[i] = {boxes.box_of(chosen[i]).center(), chosen[i]}; });
  return {items.span(), [&](std::uint32_t triangle) { return boxes.box_of(triangle); }, boxes.stars_.of_triangles()};
}

}  // namespace isoextract::mesh
