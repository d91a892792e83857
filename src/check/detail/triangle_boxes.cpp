#include "check/detail/triangle_boxes.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include <tbb/parallel_for.h>

namespace isoextract::check {

TriangleBoxes::TriangleBoxes(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles,
                             std::span<const std::uint32_t> chosen, const TriangleStars* stars)
    : positions_(positions), triangles_(triangles), slots_(chosen.size()), stars_(stars) {
  while (chosen.size() > kLeafTriangles << depth_) ++depth_;
  boxes_ = Buffer<FloatBox>((std::size_t{2} << depth_) - 1);
  if (stars != nullptr && !stars->empty()) directions_ = Buffer<Directions>(boxes_.size());
  Buffer<Item> items(chosen.size());
  tbb::parallel_for(std::size_t{0}, chosen.size(), [&](std::size_t i) {
    const FloatBox box = box_of(chosen[i]);
    const std::uint32_t star = directions_.empty() ? TriangleStars::kNone : stars->star_of(chosen[i]);
    items[i] = {box.min * 0.5F + box.max * 0.5F, chosen[i], star};  // a sum may leave the range of float
  });
  build(items.span(), {0, 0});
}

void TriangleBoxes::add_directions(const Directions& more, Directions& all) {
  all = all.star == more.star ? Directions{all.star, all.box.with(more.box)} : Directions();
}

void TriangleBoxes::build(std::span<Item> items, const Node& node) {
  if (node.level == depth_) {
    FloatBox box{glm::vec3(std::numeric_limits<float>::infinity()), glm::vec3(-std::numeric_limits<float>::infinity())};
    const std::size_t first = first_slot(node);
    for (std::size_t i = 0; i < items.size(); ++i) {
      slots_[first + i] = items[i].triangle;
      const FloatBox one = box_of(items[i].triangle);
      box = box.with(one);
    }
    boxes_[node.index()] = box;
    if (directions_.empty()) return;
    Directions& all = directions_[node.index()] = directions_of(items[0].triangle);
    for (const Item& item : items.subspan(1)) add_directions(directions_of(item.triangle), all);
    return;
  }
  glm::vec3 low = items[0].centre;
  glm::vec3 high = low;
  for (const Item& item : items) {
    low = glm::min(low, item.centre);
    high = glm::max(high, item.centre);
  }
  const bool is_mixed = !directions_.empty() &&
                        std::ranges::adjacent_find(items, std::ranges::not_equal_to(), &Item::star) != items.end();
  // In halves: the extent itself may be beyond float.
  const glm::vec3 extent = high * 0.5F - low * 0.5F;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::size_t half = first_slot(node.child(1)) - first_slot(node);
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(),
                   [axis, is_mixed](const Item& a, const Item& b) {
                     if (is_mixed && a.star != b.star) return a.star < b.star;
                     return a.centre[axis] != b.centre[axis] ? a.centre[axis] < b.centre[axis]
                                                             : a.triangle < b.triangle;
                   });
  const auto left = [&] { build(items.first(half), node.child(0)); };
  const auto right = [&] { build(items.subspan(half), node.child(1)); };
  if (is_large(node)) {
    tbb::parallel_invoke(left, right);
  } else {
    left();
    right();
  }
  const FloatBox& a = box(node.child(0));
  const FloatBox& b = box(node.child(1));
  boxes_[node.index()] = a.with(b);
  if (directions_.empty()) return;
  directions_[node.index()] = directions_[node.child(0).index()];
  add_directions(directions_[node.child(1).index()], directions_[node.index()]);
}

}  // namespace isoextract::check
