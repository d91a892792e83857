// A bounding volume hierarchy over triangles that says which of them come near each other or near a box.
//
// A complete binary tree, split at the median of the boxes' centres along their longest axis, as mesh::TriangleTree is:
// its 2^d leaves share the triangles evenly however they lie, and a node stores nothing but its box. Where there are
// stars, triangles of one star lie side by side in it, and nodes of one star have a box of directions besides.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include <tbb/parallel_invoke.h>
#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "check/detail/triangle_stars.hpp"

namespace isoextract::check {

class TriangleBoxes {
 public:
  // `chosen` are numbers of triangles, at least one; positions are finite. The tree keeps references to positions and
  // triangles, and a copy of the numbers, and to `stars`, which are of the same triangles. The same for any number of
  // threads. Throws std::bad_alloc.
  TriangleBoxes(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles,
                std::span<const std::uint32_t> chosen, const TriangleStars* stars = nullptr);

  // What making it takes, for a caller to reserve.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t chosen) {
    return chosen * (sizeof(Item) + sizeof(std::uint32_t) + 2 * sizeof(FloatBox));
  }
  // What it takes more with stars.
  [[nodiscard]] static std::uint64_t star_bytes(std::uint64_t chosen) { return 2 * chosen * sizeof(Directions); }

  [[nodiscard]] FloatBox box_of(std::uint32_t triangle) const {
    const glm::uvec3& t = triangles_[triangle];
    const glm::vec3& a = positions_[t.x];
    const glm::vec3& b = positions_[t.y];
    const glm::vec3& c = positions_[t.z];
    return {glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
  }

  // Calls visit(i, j) once for each two chosen triangles that may have more in common than a corner or a side, as their
  // boxes meet and those of their directions, in any order and from several threads, until `stopped` is true.
  // advance(n) says that n more triangles were met with those of their own part of the tree.
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
    std::uint32_t star;
  };
  // Of a node or a triangle.
  struct Directions {
    std::uint32_t star = TriangleStars::kNone;
    FloatBox box{};  // in the star's directions
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
  static void add_directions(const Directions& more, Directions& all);

  [[nodiscard]] Directions directions_of(std::uint32_t triangle) const {
    const std::uint32_t star = stars_->star_of(triangle);
    if (star == TriangleStars::kNone) return {};
    return {star, stars_->directions(star, triangles_[triangle])};
  }
  // Whether what is in the boxes may have more in common than the middles of stars.
  [[nodiscard]] bool may_meet(const FloatBox& a, const Directions& of_a, const FloatBox& b,
                              const Directions& of_b) const {
    if (of_a.star != TriangleStars::kNone && of_a.star == of_b.star) return of_a.box.meets(of_b.box);
    if (!a.meets(b)) return false;
    if (of_a.star != TriangleStars::kNone && !stars_->seen(of_a.star, b).meets(of_a.box)) return false;
    return of_b.star == TriangleStars::kNone || stars_->seen(of_b.star, a).meets(of_b.box);
  }
  [[nodiscard]] bool may_meet(const Node& a, const Node& b) const {
    if (directions_.empty()) return box(a).meets(box(b));
    return may_meet(box(a), directions_[a.index()], box(b), directions_[b.index()]);
  }
  // Of triangles whose boxes are known.
  [[nodiscard]] bool may_meet(std::uint32_t i, const FloatBox& of_i, std::uint32_t j, const FloatBox& of_j) const {
    if (directions_.empty()) return of_i.meets(of_j);
    return may_meet(of_i, directions_of(i), of_j, directions_of(j));
  }

  template <class Visit, class Advance>
  void within(const Node& node, const std::atomic<bool>& stopped, const Visit& visit, const Advance& advance) const {
    if (stopped.load(std::memory_order_relaxed)) return;
    if (node.level == depth_) {
      const auto slots = slots_of(node);
      for (std::size_t i = 0; i < slots.size(); ++i) {
        const FloatBox first = box_of(slots[i]);
        for (std::size_t j = i + 1; j < slots.size(); ++j) {
          if (may_meet(slots[i], first, slots[j], box_of(slots[j]))) visit(slots[i], slots[j]);
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
    if (stopped.load(std::memory_order_relaxed) || !may_meet(a, b)) return;
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
        if (may_meet(i, first, others[j], boxes[j])) visit(i, others[j]);
      }
    }
  }

  std::span<const glm::vec3> positions_;
  std::span<const glm::uvec3> triangles_;
  std::size_t depth_ = 0;
  Buffer<std::uint32_t> slots_;  // numbers of triangles in the order of the tree
  Buffer<FloatBox> boxes_;       // level by level
  const TriangleStars* stars_;
  Buffer<Directions> directions_;  // likewise; none without stars
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

}  // namespace isoextract::check
