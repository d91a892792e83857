// Finds the nearest of many points, however unevenly they are distributed: a k-d tree of boxes, each split at the
// median along its longest side (J. L. Bentley: Multidimensional binary search trees used for associative searching.
// CACM 18(9), 1975).
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"

namespace isoextract::points {

class NearestTree {
 public:
  // Builds the tree; skips non-finite points. `points` must outlive the tree, which refers to them. Fails as
  // Context::reserve() and Context::check() do; `label` names the points in the message.
  [[nodiscard]] static Result<NearestTree> make(std::span<const glm::dvec3> points, const Context& context,
                                                const std::string& label);

  struct Found {
    double squared_distance = std::numeric_limits<double>::infinity();
    std::uint32_t point = 0;  // the lowest index among the nearest points; undefined if the distance is infinite
  };

  [[nodiscard]] Found nearest(const glm::dvec3& p) const;

  // Returns a lower bound of the squared distance from `p` to any point; infinite without points.
  [[nodiscard]] double squared_distance_to_bounds(const glm::dvec3& p) const;

  // Sets `found` to the nearest points at up to `count` different positions, other than `p`, in order of distance. Of
  // coincident points it finds one.
  void nearest_positions(const glm::dvec3& p, std::size_t count, std::vector<Found>& found) const;

 private:
  struct Node {
    glm::dvec3 low;
    glm::dvec3 high;
    std::uint32_t first;  // index into order_
    std::uint32_t last;
    bool leaf;
  };
  void build(std::size_t node, std::uint32_t first, std::uint32_t last);
  void search(std::size_t node, const glm::dvec3& p, Found& found) const;
  void search_positions(std::size_t node, const glm::dvec3& p, std::size_t count, std::vector<Found>& found) const;
  // Calls visit(child) for the children of a node whose squared distance is at most reach(), the nearer one first.
  template <class Reach, class Visit>
  void visit_children(std::size_t node, const glm::dvec3& p, const Reach& reach, const Visit& visit) const;

  std::span<const glm::dvec3> points_;
  Buffer<std::uint32_t> order_;
  Buffer<Node> nodes_;  // the children of node n are 2n + 1 and 2n + 2
  Reservation memory_;
};

}  // namespace isoextract::points
