// A bounding volume hierarchy over triangles that says which of them come near each other or near a box.
//
// A complete binary tree, split at the median of the boxes' centres along their longest axis, as mesh::TriangleTree is:
// its 2^d leaves share the triangles evenly however they lie, and a node stores nothing but its box.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include <tbb/parallel_invoke.h>
#include <glm/glm.hpp>

#include "base/buffer.hpp"

namespace isoextract::measure {

struct FloatBox {
  glm::vec3 min, max;

  // With their border.
  [[nodiscard]] bool meets(const FloatBox& other) const {
    return min.x <= other.max.x && other.min.x <= max.x && min.y <= other.max.y && other.min.y <= max.y &&
           min.z <= other.max.z && other.min.z <= max.z;
  }
};

class TriangleBoxes {
 public:
  // `chosen` are numbers of triangles, at least one; positions are finite. The tree keeps references to positions and
  // triangles, and a copy of the numbers. The same for any number of threads. Throws std::bad_alloc.
  TriangleBoxes(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles,
                std::span<const std::uint32_t> chosen);

  // What making it takes, for a caller to reserve.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t chosen) {
    return chosen * (sizeof(Item) + sizeof(std::uint32_t) + 2 * sizeof(FloatBox));
  }

  [[nodiscard]] FloatBox box_of(std::uint32_t triangle) const {
    const glm::uvec3& t = triangles_[triangle];
    const glm::vec3& a = positions_[t.x];
    const glm::vec3& b = positions_[t.y];
    const glm::vec3& c = positions_[t.z];
    return {glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
  }

  // Calls visit(i, j) once for each two chosen triangles whose boxes meet, in any order and from several threads, until
  // `stopped` is true. advance(n) says that n more triangles were met with those of their own part of the tree.
  template <class Visit, class Advance>
  void for_near_pairs(const std::atomic<bool>& stopped, const Visit& visit, const Advance& advance) const {
    within({0, 0}, stopped, visit, advance);
  }

  // Calls visit(i) for each chosen triangle whose box meets `near`.
  template <class Visit>
  void for_each_near(const FloatBox& near, const Visit& visit) const;

 private:
  static constexpr std::size_t kLeafTriangles = 4;
  static constexpr std::size_t kParallelTriangles = 1 << 11;

  struct Item {
    glm::vec3 centre;
    std::uint32_t triangle;
  };
  struct Node {
    std::size_t level;
    std::size_t number;  // on its level
    [[nodiscard]] Node child(std::size_t which) const { return {level + 1, 2 * number + which}; }
    [[nodiscard]] std::size_t index() const { return (std::size_t{1} << level) - 1 + number; }
  };

  [[nodiscard]] std::size_t first_slot(const Node& node) const { return (node.number * slots_.size()) >> node.level; }
  [[nodiscard]] std::span<const std::uint32_t> slots_of(const Node& node) const {
    const std::size_t first = first_slot(node);
    return slots_.span().subspan(first, first_slot({node.level, node.number + 1}) - first);
  }
  [[nodiscard]] const FloatBox& box(const Node& node) const { return boxes_[node.index()]; }
  // Whether there is enough of it for several threads. By its level, so that no two sizes meet at a border.
  [[nodiscard]] bool is_large(const Node& node) const { return (slots_.size() >> node.level) > kParallelTriangles; }

  void build(std::span<Item> items, const Node& node);

  template <class Visit, class Advance>
  void within(const Node& node, const std::atomic<bool>& stopped, const Visit& visit, const Advance& advance) const {
    if (stopped.load(std::memory_order_relaxed)) return;
    if (node.level == depth_) {
      const auto slots = slots_of(node);
      for (std::size_t i = 0; i < slots.size(); ++i) {
        const FloatBox first = box_of(slots[i]);
        for (std::size_t j = i + 1; j < slots.size(); ++j) {
          if (first.meets(box_of(slots[j]))) visit(slots[i], slots[j]);
        }
      }
      return;
    }
    const auto left = [&] { within(node.child(0), stopped, visit, advance); };
    const auto right = [&] { within(node.child(1), stopped, visit, advance); };
    const auto across = [&] { between(node.child(0), node.child(1), stopped, visit); };
    if (is_large(node)) {
      tbb::parallel_invoke(left, right, across);
      return;
    }
    left();
    right();
    across();
    if (node.level == 0 || is_large({node.level - 1, node.number / 2})) advance(slots_of(node).size());
  }

  // Of two nodes of one level.
  template <class Visit>
  void between(const Node& a, const Node& b, const std::atomic<bool>& stopped, const Visit& visit) const {
    if (stopped.load(std::memory_order_relaxed) || !box(a).meets(box(b))) return;
    if (a.level == depth_) {
      visit_leaves(a, b, visit);
      return;
    }
    const auto part = [&](std::size_t i) {
      return [&, i] { between(a.child(i / 2), b.child(i % 2), stopped, visit); };
    };
    if (is_large(a)) {
      tbb::parallel_invoke(part(0), part(1), part(2), part(3));
      return;
    }
    for (std::size_t i = 0; i < 4; ++i) part(i)();
  }

  template <class Visit>
  void visit_leaves(const Node& a, const Node& b, const Visit& visit) const {
    const auto others = slots_of(b);
    std::array<FloatBox, kLeafTriangles> boxes;
    for (std::size_t j = 0; j < others.size(); ++j) boxes[j] = box_of(others[j]);
    for (const std::uint32_t i : slots_of(a)) {
      const FloatBox first = box_of(i);
      if (!first.meets(box(b))) continue;
      for (std::size_t j = 0; j < others.size(); ++j) {
        if (first.meets(boxes[j])) visit(i, others[j]);
      }
    }
  }

  std::span<const glm::vec3> positions_;
  std::span<const glm::uvec3> triangles_;
  std::size_t depth_ = 0;
  Buffer<std::uint32_t> slots_;  // numbers of triangles in the order of the tree
  Buffer<FloatBox> boxes_;       // level by level
};

template <class Visit>
void TriangleBoxes::for_each_near(const FloatBox& near, const Visit& visit) const {
  constexpr std::size_t kMostLevels = 34;  // slots have 32 bits
  std::array<Node, kMostLevels> waiting;
  std::size_t count = 0;
  waiting[count++] = {0, 0};
  while (count > 0) {
    const Node node = waiting[--count];
    if (!near.meets(box(node))) continue;
    if (node.level < depth_) {
      waiting[count++] = node.child(1);
      waiting[count++] = node.child(0);
      continue;
    }
    for (const std::uint32_t triangle : slots_of(node)) {
      if (near.meets(box_of(triangle))) visit(triangle);
    }
  }
}

}  // namespace isoextract::measure
