// Finds triangles near each other with a BoxTree. Nodes whose triangles all belong to one star also have a box of
// directions.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include <tbb/parallel_invoke.h>
#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/detail/triangle_stars.hpp"

namespace isoextract::mesh {

class TriangleBoxes {
 public:
  // `chosen` are triangle numbers, at least one; positions are finite. Keeps references to positions, triangles and
  // `stars`, which must cover the same triangles. Does not depend on the number of threads. Throws std::bad_alloc.
  TriangleBoxes(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles,
                std::span<const std::uint32_t> chosen, const CrowdedStars& stars);

  // Returns the bytes that the construction needs; the caller reserves them.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t chosen) { return BoxTree::bytes(chosen); }
  // Returns the additional bytes if there are stars.
  [[nodiscard]] static std::uint64_t star_bytes(std::uint64_t chosen) { return (chosen + 1) * sizeof(Directions); }

  [[nodiscard]] FloatBox box_of(std::uint32_t triangle) const {
    const glm::uvec3& t = triangles_[triangle];
    return box_around(positions_[t.x], positions_[t.y], positions_[t.z]);
  }

  // Calls visit(i, j) once for each pair of chosen triangles that may have more in common than a corner or a side:
  // their boxes and their boxes of directions overlap. Calls come in any order and from several threads, until
  // `stopped` is true. advance(n) reports n more triangles compared with all others of their subtree.
  template <class Visit, class Advance>
  void for_each_near_pair(const std::atomic<bool>& stopped, const Visit& visit, const Advance& advance) const {
    within({0, 0}, stopped, visit, advance);
  }

  // Calls visit(i) for each chosen triangle whose box overlaps `near`.
  template <class Visit>
  void for_each_near(const FloatBox& near, const Visit& visit) const {
    tree_.for_each_near(near, [&](std::uint32_t triangle) {
      if (near.meets(box_of(triangle))) visit(triangle);
    });
  }

 private:
  static constexpr std::size_t kParallelTriangles = 1 << 11;
  using Node = BoxTree::Node;

  // The common star of the triangles of a node, or of one triangle, and their directions in it.
  struct Directions {
    std::uint32_t star = CrowdedStars::kNone;
    FloatBox box{};  // as seen from the middle of the star
    [[nodiscard]] Directions with(const Directions& other) const {
      return star == other.star ? Directions{star, box.with(other.box)} : Directions();
    }
  };
  [[nodiscard]] const FloatBox& box(const Node& node) const { return tree_.box(node.index()); }
  // Returns whether several threads should share the node. Depends on the level only, so all nodes of a level agree.
  [[nodiscard]] bool is_large(const Node& node) const {
    return (tree_.numbers().size() >> node.level) > kParallelTriangles;
  }
  static BoxTree tree_of(const TriangleBoxes& boxes, std::span<const std::uint32_t> chosen);

  [[nodiscard]] Directions directions_of(std::uint32_t triangle) const {
    const std::uint32_t star = stars_.star_of(triangle);
    if (star == CrowdedStars::kNone) return {};
    return {star, stars_.directions(star, triangles_[triangle])};
  }
  // Returns whether the contents of two boxes may have more in common than the middles of stars.
  [[nodiscard]] bool may_meet(const FloatBox& a, const Directions& of_a, const FloatBox& b,
                              const Directions& of_b) const {
    if (of_a.star != CrowdedStars::kNone && of_a.star == of_b.star) return of_a.box.meets(of_b.box);
    if (!a.meets(b)) return false;
    if (of_a.star != CrowdedStars::kNone && !stars_.seen(of_a.star, b).meets(of_a.box)) return false;
    return of_b.star == CrowdedStars::kNone || stars_.seen(of_b.star, a).meets(of_b.box);
  }
  [[nodiscard]] bool may_meet(const Node& a, const Node& b) const {
    if (directions_.empty()) return box(a).meets(box(b));
    return may_meet(box(a), directions_[a.index()], box(b), directions_[b.index()]);
  }
  // Compares triangles whose boxes are known.
  [[nodiscard]] bool may_meet(std::uint32_t i, const FloatBox& of_i, std::uint32_t j, const FloatBox& of_j) const {
    if (directions_.empty()) return of_i.meets(of_j);
    return may_meet(of_i, directions_of(i), of_j, directions_of(j));
  }

  template <class Visit, class Advance>
  void within(const Node& node, const std::atomic<bool>& stopped, const Visit& visit, const Advance& advance) const {
    if (stopped.load(std::memory_order_relaxed)) return;
    if (node.level == tree_.depth()) {
      const auto slots = tree_.numbers_of(node);
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
    if (node.level == 0 || is_large({node.level - 1, node.number / 2})) advance(tree_.numbers_of(node).size());
  }

  // Compares two nodes of one level.
  template <class Visit>
  void between(const Node& a, const Node& b, const std::atomic<bool>& stopped, const Visit& visit) const {
    if (stopped.load(std::memory_order_relaxed) || !may_meet(a, b)) return;
    if (a.level == tree_.depth()) {
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
    const auto others = tree_.numbers_of(b);
    std::array<FloatBox, BoxTree::kLeafSize> boxes;
    for (std::size_t j = 0; j < others.size(); ++j) boxes[j] = box_of(others[j]);
    for (const std::uint32_t i : tree_.numbers_of(a)) {
      const FloatBox first = box_of(i);
      if (!first.meets(box(b))) continue;
      for (std::size_t j = 0; j < others.size(); ++j) {
        if (may_meet(i, first, others[j], boxes[j])) visit(i, others[j]);
      }
    }
  }

  std::span<const glm::vec3> positions_;
  std::span<const glm::uvec3> triangles_;
  const CrowdedStars& stars_;
  BoxTree tree_;
  Buffer<Directions> directions_;  // one for each node; empty without stars
};

}  // namespace isoextract::mesh
