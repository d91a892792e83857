// A bounding volume hierarchy over items with boxes: triangles, rays, components.
//
// A complete binary tree, split at the median of the items' centers along their longest axis. Its 2^d leaves share the
// items evenly for any input. The items of a node therefore follow from its number, and a node stores its box only.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/parallel.hpp"
#include "mesh/float4.hpp"

namespace isoextract::mesh {

struct FloatBox {
  glm::vec3 min{std::numeric_limits<float>::infinity()};
  glm::vec3 max{-std::numeric_limits<float>::infinity()};

  // Returns whether the boxes overlap or touch.
  [[nodiscard]] bool meets(const FloatBox& other) const {
    return min.x <= other.max.x && other.min.x <= max.x && min.y <= other.max.y && other.min.y <= max.y &&
           min.z <= other.max.z && other.min.z <= max.z;
  }
  [[nodiscard]] bool contains(const FloatBox& other) const {
    return min.x <= other.min.x && other.max.x <= max.x && min.y <= other.min.y && other.max.y <= max.y &&
           min.z <= other.min.z && other.max.z <= max.z;
  }
  [[nodiscard]] FloatBox with(const FloatBox& other) const {
    return {glm::min(min, other.min), glm::max(max, other.max)};
  }
  [[nodiscard]] glm::vec3 center() const { return min * 0.5F + max * 0.5F; }  // a sum could overflow
};

[[nodiscard]] inline FloatBox box_around(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  return {glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
}

// A box that is compared with many other boxes, four floats at a time.
class BoxQuery {
 public:
  explicit BoxQuery(const FloatBox& box)
      : low_{box.min.x, box.min.y, box.min.z, -std::numeric_limits<float>::infinity()},
        high_{box.max.x, box.max.y, box.max.z, std::numeric_limits<float>::infinity()} {}

  // Returns what FloatBox::meets() returns.
  [[nodiscard]] bool meets(const FloatBox& other) const {
    static_assert(sizeof(FloatBox) == 6 * sizeof(float));
    return meets(load4(&other.min.x), last_three(load4(&other.min.z)));
  }
  // Compares with the bounding box of a triangle, whose three corners follow each other in memory.
  [[nodiscard]] bool meets_triangle(const glm::vec3* corners) const {
    const Float4 a = load4(&corners[0].x);
    const Float4 b = load4(&corners[1].x);
    const Float4 c = last_three(load4(&corners[1].z));
    return meets(min4(min4(a, b), c), max4(max4(a, b), c));
  }

 private:
  // Returns whether the boxes meet. The last lane never decides: low_ and high_ are infinite there.
  [[nodiscard]] bool meets(const Float4& low, const Float4& high) const { return !any4((low > high_) | (low_ > high)); }

  Float4 low_;
  Float4 high_;
};

class BoxTree {
 public:
  static constexpr std::size_t kLeafSize = 4;

  struct Item {
    glm::vec3 center;
    std::uint32_t number;
  };
  struct Node {
    std::size_t level;
    std::size_t number;  // within its level
    [[nodiscard]] Node child(std::size_t which) const { return {level + 1, 2 * number + which}; }
    [[nodiscard]] std::size_t index() const { return (std::size_t{1} << level) - 1 + number; }
  };

  // Returns the bytes that construction needs; the caller reserves them.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t items) {
    return items * (sizeof(Item) + sizeof(std::uint32_t)) + (items + 1) * sizeof(FloatBox);
  }

  // Needs at least one item, with finite centers; sorts `items` into tree order. box_of(number) returns the box of an
  // item. `groups` is empty, or has the group of each number: nodes with several groups are split by group, so that the
  // items of a group are in adjacent leaves. The tree is the same for any number of threads. Throws std::bad_alloc.
  template <class BoxOf>
  BoxTree(std::span<Item> items, const BoxOf& box_of, std::span<const std::uint32_t> groups = {})
      : BoxTree(items, groups) {
    fit(boxes_.span(), box_of);
  }

  [[nodiscard]] std::size_t depth() const { return depth_; }
  [[nodiscard]] std::size_t leaves() const { return std::size_t{1} << depth_; }
  [[nodiscard]] Node leaf(std::size_t number) const { return {depth_, number}; }
  [[nodiscard]] std::size_t leaf_of(std::size_t slot) const {
    std::size_t number = (slot << depth_) / slots_.size();
    while (end_slot(leaf(number)) <= slot) ++number;
    return number;
  }
  // Returns the numbers of the items in tree order. The position of an item in this order is its slot.
  [[nodiscard]] std::span<const std::uint32_t> numbers() const { return slots_.span(); }
  [[nodiscard]] std::size_t first_slot(const Node& node) const { return node.number * slots_.size() >> node.level; }
  [[nodiscard]] std::size_t end_slot(const Node& node) const { return first_slot({node.level, node.number + 1}); }
  [[nodiscard]] std::span<const std::uint32_t> numbers_of(const Node& node) const {
    return numbers().subspan(first_slot(node), end_slot(node) - first_slot(node));
  }
  // Returns the box of the node with this Node::index(): node k has the children 2k + 1 and 2k + 2.
  [[nodiscard]] const FloatBox& box(std::size_t index) const { return boxes_[index]; }
  [[nodiscard]] std::size_t nodes() const { return boxes_.size(); }

  // Fills `all`, indexed by node, from the leaves up: the union, by with(), of box_of() of the node's items.
  template <class Box, class BoxOf>
  void fit(std::span<Box> all, const BoxOf& box_of) const;

  // Enlarges the boxes of the nodes that hold this slot, so that they contain `box`.
  void enlarge(std::size_t slot, const FloatBox& box);

  // A few nodes, without common items.
  class Nodes {
   public:
    static constexpr std::size_t kMost = 8;
    void add(const Node& node) { nodes_[count_++] = node; }
    [[nodiscard]] std::span<const Node> span() const { return {nodes_.data(), count_}; }

   private:
    std::array<Node, kMost> nodes_{};
    std::size_t count_ = 0;
  };
  // Returns nodes that hold all items in leaves whose boxes meet `near`. A search for a smaller box may start at them.
  [[nodiscard]] Nodes nodes_near(const FloatBox& near) const;
  static constexpr std::array<Node, 1> kRoot{{{0, 0}}};

  // Returns whether the box of a leaf below `from`, at most Nodes::kMost nodes, meets `near`.
  [[nodiscard]] bool any_leaf_near(const FloatBox& near, std::span<const Node> from = kRoot) const {
    return any_leaf_near(near, from, [](const Node& /*leaf*/) { return true; });
  }
  // Calls visit(number) for each item below `from` in a leaf whose box meets `near`. The item's own box may not meet
  // it.
  template <class Visit>
  void for_each_near(const FloatBox& near, const Visit& visit, std::span<const Node> from = kRoot) const {
    for_each_slot_near(
        near, [&](std::size_t slot) { visit(slots_[slot]); }, from);
  }
  // Calls visit(slot) for the same items.
  template <class Visit>
  void for_each_slot_near(const FloatBox& near, const Visit& visit, std::span<const Node> from = kRoot) const {
    const auto visit_slots = [&](const Node& leaf) {
      const std::size_t end = end_slot(leaf);
      for (std::size_t slot = first_slot(leaf); slot < end; ++slot) visit(slot);
      return false;
    };
    static_cast<void>(any_leaf_near(near, from, visit_slots));
  }

 private:
  BoxTree(std::span<Item> items, std::span<const std::uint32_t> groups);
  template <class Holds>
  [[nodiscard]] bool any_leaf_near(const FloatBox& near, std::span<const Node> from, const Holds& holds) const;
  void order(std::span<Item> items, const Node& node, std::span<const std::uint32_t> groups) const;

  std::size_t depth_ = 0;
  Buffer<std::uint32_t> slots_;
  Buffer<FloatBox> boxes_;
};

template <class Box, class BoxOf>
void BoxTree::fit(std::span<Box> all, const BoxOf& box_of) const {
  constexpr std::size_t kGrain = 1 << 9;
  for (std::size_t level = depth_ + 1; level-- > 0;) {
    const auto fit_node = [&](std::size_t number) {
      const Node node{level, number};
      if (level < depth_) {
        all[node.index()] = all[node.child(0).index()].with(all[node.child(1).index()]);
        return;
      }
      const auto inside = numbers_of(node);
      Box box = box_of(inside[0]);
      for (const std::uint32_t item : inside.subspan(1)) box = box.with(box_of(item));
      all[node.index()] = box;
    };
    for_each_index(std::size_t{1} << level, fit_node, kGrain);
  }
}

// Returns whether holds(leaf) is true of a leaf below `from` whose box meets `near`; asks no other leaf after it.
template <class Holds>
bool BoxTree::any_leaf_near(const FloatBox& near, std::span<const Node> from, const Holds& holds) const {
  constexpr std::size_t kMostLevels = 34;  // slots have 32 bits
  std::array<Node, kMostLevels + Nodes::kMost> waiting;
  std::size_t count = from.size();
  std::ranges::reverse_copy(from, waiting.begin());
  const BoxQuery query(near);
  while (count > 0) {
    const Node node = waiting[--count];
    if (!query.meets(boxes_[node.index()])) continue;
    if (node.level < depth_) {
      waiting[count++] = node.child(1);
      waiting[count++] = node.child(0);
    } else if (holds(node)) {
      return true;
    }
  }
  return false;
}

}  // namespace isoextract::mesh
