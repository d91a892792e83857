#include "mesh/box_tree.hpp"

#include <algorithm>
#include <functional>

#include <tbb/parallel_invoke.h>

namespace isoextract::mesh {
namespace {

// Returns the box of the centers.
FloatBox range_of(std::span<const BoxTree::Item> items) {
  static_assert(sizeof(BoxTree::Item) == sizeof(Float4));
  Float4 low = load4(&items[0].center.x);
  Float4 high = low;
  for (const BoxTree::Item& item : items) {  // the lane of `number` does not count
    const Float4 center = load4(&item.center.x);
    low = min4(low, center);
    high = max4(high, center);
  }
  return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}

// Sorts the items around `half` by a coordinate, then by number. The axis is known to the compiler, which saves time.
template <int axis>
void split_along(std::span<BoxTree::Item> items, std::span<BoxTree::Item>::iterator half) {
  std::nth_element(items.begin(), half, items.end(), [](const BoxTree::Item& a, const BoxTree::Item& b) {
    return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.number < b.number;
  });
}

}  // namespace

BoxTree::BoxTree(std::span<Item> items, std::span<const std::uint32_t> groups) : slots_(items.size()) {
  while (items.size() > kLeafSize << depth_) ++depth_;
  boxes_ = Buffer<FloatBox>((std::size_t{2} << depth_) - 1);
  order(items, {0, 0}, groups);
  std::ranges::transform(items, slots_.begin(), &Item::number);
}

void BoxTree::enlarge(std::size_t slot, const FloatBox& box) {
  for (Node node = leaf(leaf_of(slot));; node = {node.level - 1, node.number / 2}) {
    FloatBox& own = boxes_[node.index()];
    if (own.contains(box)) return;  // so do the boxes above
    own = own.with(box);
    if (node.level == 0) return;
  }
}

// Sorts the items of a node into tree order.
void BoxTree::order(std::span<Item> items, const Node& node, std::span<const std::uint32_t> groups) const {
  constexpr std::size_t kParallelItems = 1 << 12;
  if (node.level == depth_) return;
  const auto [low, high] = range_of(items);
  const bool is_mixed = !groups.empty() && std::ranges::adjacent_find(
                                               items, std::ranges::not_equal_to(),
                                               [&](const Item& item) { return groups[item.number]; }) != items.end();
  // Computes with halves, because the extent itself could overflow.
  const glm::vec3 extent = high * 0.5F - low * 0.5F;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const auto half = items.begin() + static_cast<std::ptrdiff_t>(first_slot(node.child(1)) - first_slot(node));
  if (is_mixed) {
    std::nth_element(items.begin(), half, items.end(), [&](const Item& a, const Item& b) {
      if (groups[a.number] != groups[b.number]) return groups[a.number] < groups[b.number];
      return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.number < b.number;
    });
  } else if (axis == 0) {
    split_along<0>(items, half);
  } else if (axis == 1) {
    split_along<1>(items, half);
  } else {
    split_along<2>(items, half);
  }
  const auto left = [&] { order({items.begin(), half}, node.child(0), groups); };
  const auto right = [&] { order({half, items.end()}, node.child(1), groups); };
  if (items.size() > kParallelItems) {
    tbb::parallel_invoke(left, right);
  } else {
    left();
    right();
  }
}

}  // namespace isoextract::mesh
