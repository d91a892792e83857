#include "mesh/box_tree.hpp"

#include <algorithm>
#include <array>
#include <bit>
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

// Returns a number that orders items by a coordinate, then by number. The axis is known to the compiler, which saves
// time.
template <int axis>
std::uint64_t key_along(const BoxTree::Item& item) {
  constexpr std::uint32_t kSign = std::uint32_t{1} << 31U;
  const auto bits = std::bit_cast<std::uint32_t>(item.center[axis] + 0.0F);  // -0 becomes 0
  const std::uint32_t ascending = (bits & kSign) != 0 ? ~bits : bits | kSign;
  return (std::uint64_t{ascending} << 32U) | item.number;
}

// Returns the key at about this share of the items, neither the least nor the greatest of them.
template <int axis>
std::uint64_t pivot_along(std::span<const BoxTree::Item> items, std::size_t wanted) {
  constexpr std::size_t kMostSamples = 31;
  constexpr std::size_t kManyItems = 64;
  constexpr std::size_t kFewSamples = 5;
  const std::size_t samples =
      items.size() < kManyItems ? kFewSamples : std::min(kMostSamples, kFewSamples + items.size() / kManyItems);
  std::array<std::uint64_t, kMostSamples> keys;
  for (std::size_t i = 0; i < samples; ++i) {
    const std::uint64_t key = key_along<axis>(items[(2 * i + 1) * items.size() / (2 * samples)]);
    std::size_t at = i;
    for (; at > 0 && keys[at - 1] > key; --at) keys[at] = keys[at - 1];
    keys[at] = key;
  }
  return keys[std::clamp<std::size_t>((wanted * samples + items.size() / 2) / items.size(), 1, samples - 1)];
}

// Moves the items with keys below the pivot to the front, without branches. Returns their number.
template <int axis>
std::size_t partition_along(std::span<BoxTree::Item> items, std::uint64_t pivot) {
  std::size_t below = 0;
  for (BoxTree::Item& item : items) {
    const BoxTree::Item moved = item;
    item = items[below];
    items[below] = moved;
    below += key_along<axis>(moved) < pivot ? 1 : 0;
  }
  return below;
}

// Moves the `first` items with the least keys to the front. std::nth_element() takes twice as long, because its
// branches are hard to predict.
template <int axis>
void split_along(std::span<BoxTree::Item> items, std::size_t first) {
  constexpr std::size_t kFewItems = 8;
  constexpr int kMostRounds = 64;  // far more than are usual
  for (int round = 0; round < kMostRounds; ++round) {
    if (first == 0 || first == items.size()) return;
    if (items.size() <= kFewItems) break;
    const std::size_t below = partition_along<axis>(items, pivot_along<axis>(items, first));
    if (below <= first) {
      items = items.subspan(below);
      first -= below;
    } else {
      items = items.first(below);
    }
  }
  std::nth_element(
      items.begin(), items.begin() + static_cast<std::ptrdiff_t>(first), items.end(),
      [](const BoxTree::Item& a, const BoxTree::Item& b) { return key_along<axis>(a) < key_along<axis>(b); });
}

}  // namespace

BoxTree::BoxTree(std::span<Item> items, std::span<const std::uint32_t> groups) : slots_(items.size()) {
  while (items.size() > kLeafSize << depth_) ++depth_;
  boxes_ = Buffer<FloatBox>((std::size_t{2} << depth_) - 1);
  order(items, {0, 0}, groups);
  std::ranges::transform(items, slots_.begin(), &Item::number);
}

BoxTree::Nodes BoxTree::nodes_near(const FloatBox& near) const {
  const BoxQuery query(near);
  Nodes nodes;
  if (query.meets(boxes_[0])) nodes.add({0, 0});
  for (std::size_t level = 0; level < depth_; ++level) {
    Nodes below;
    for (const Node& node : nodes.span()) {
      for (const Node& child : {node.child(0), node.child(1)}) {
        if (!query.meets(boxes_[child.index()])) continue;
        if (below.span().size() == Nodes::kMost) return nodes;
        below.add(child);
      }
    }
    nodes = below;
  }
  return nodes;
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
  const std::size_t left_items = first_slot(node.child(1)) - first_slot(node);
  const auto half = items.begin() + static_cast<std::ptrdiff_t>(left_items);
  if (is_mixed) {
    std::nth_element(items.begin(), half, items.end(), [&](const Item& a, const Item& b) {
      if (groups[a.number] != groups[b.number]) return groups[a.number] < groups[b.number];
      return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.number < b.number;
    });
  } else if (axis == 0) {
    split_along<0>(items, left_items);
  } else if (axis == 1) {
    split_along<1>(items, left_items);
  } else {
    split_along<2>(items, left_items);
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
