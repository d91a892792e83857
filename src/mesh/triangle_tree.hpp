// A bounding volume hierarchy over the triangles of a mesh, to find the closest point of a surface.
//
// A BoxTree, split by the triangles' centroids. The boxes of long triangles that are not aligned with the axes overlap,
// for example around a corner that very many triangles share. Inner nodes then also store two slabs: pairs of parallel
// planes that enclose their triangles tightly.
#pragma once

#include <array>

#include <cstdint>
#include <limits>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "mesh/box_tree.hpp"

namespace isoextract::mesh {

class BoxFilter;  // detail/box_filter.hpp

class TriangleTree {
 public:
  struct Corners {
    glm::vec3 a, b, c;
  };

  // The closest point of the surface. A slot is a triangle's position in the order of the tree.
  struct Nearest {
    double distance_squared = std::numeric_limits<double>::infinity();
    std::uint32_t slot = 0;
    glm::dvec3 point{0.0};
  };

  // Returns the most bytes that construction needs, for the caller to reserve.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t triangles) {
    return triangles * sizeof(Corners) + BoxTree::bytes(triangles);
  }

  // Needs at least one triangle, finite positions, and indices below positions.size(). Keeps copies of the triangles.
  // The tree is the same for any number of threads. Throws std::bad_alloc.
  TriangleTree(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles);

  // Returns the closest point of all triangles, in the frame of the positions. The search starts with the triangle in
  // slot `hint`: a near one saves time and wins ties. The search ends at a squared distance of at most
  // `enough_squared`, even if another point is closer.
  [[nodiscard]] Nearest nearest(const glm::dvec3& p, std::uint32_t hint, double enough_squared = 0) const;

  // Returns the closest point of one triangle.
  [[nodiscard]] Nearest nearest_on_triangle(std::uint32_t slot, const glm::dvec3& p) const;

  // Returns the greatest squared distance of the points to one triangle. Stops at the first squared distance above
  // `enough_squared` and returns that one.
  [[nodiscard]] double max_distance_squared(std::uint32_t slot, std::span<const glm::dvec3> points,
                                            double enough_squared = std::numeric_limits<double>::infinity()) const;

  // Calls visit(slot) for each triangle in a leaf whose box meets `near`. The triangle's own box may not meet it.
  template <class Visit>
  void for_each_near(const FloatBox& near, const Visit& visit) const {
    tree_.for_each_slot_near(near, visit);
  }

  [[nodiscard]] const Corners& corners(std::uint32_t slot) const { return corners_[slot]; }
  // Returns the index in the constructor's `triangles` of the triangle in a slot.
  [[nodiscard]] std::uint32_t triangle(std::uint32_t slot) const { return tree_.numbers()[slot]; }
  [[nodiscard]] std::size_t size() const { return corners_.size(); }
  [[nodiscard]] bool has_slabs() const { return !slabs_.empty(); }

  // Returns the number of leaves that may contain a point closer to p than this squared distance: the cost of a search.
  [[nodiscard]] std::size_t count_leaves_within(const glm::dvec3& p, double squared) const;

 private:
  // The points p with low <= dot(axis, p) <= high; the length of the axis is at most 1.
  struct Slab {
    std::array<std::int16_t, 3> axis{};  // in units of 1 / kAxisOne
    float low = 0;
    float high = 0;
    [[nodiscard]] double along(const glm::dvec3& p) const;
    [[nodiscard]] double distance(const glm::dvec3& p) const;
  };

  void search_below(std::size_t node, double node_distance_squared, const BoxFilter& filter, const glm::dvec3& p,
                    double enough_squared, Nearest& best) const;
  // Searches the triangles of a leaf except the one in slot `known`.
  void search(std::size_t leaf, const BoxFilter& filter, const glm::dvec3& p, std::size_t known, Nearest& best) const;
  [[nodiscard]] bool boxes_are_loose() const;
  void make_slabs();
  [[nodiscard]] std::array<Slab, 2> slabs_of(const BoxTree::Node& node) const;
  // Returns a lower bound for the squared distance of p to the node's triangles.
  [[nodiscard]] inline double bound_squared(std::size_t node, const BoxFilter& filter, const glm::dvec3& p) const;

  BoxTree tree_;
  Buffer<Corners> corners_;            // by slot
  Buffer<std::array<Slab, 2>> slabs_;  // of the inner nodes; empty where boxes are tight
};

}  // namespace isoextract::mesh
