// A bounding volume hierarchy over the triangles of a mesh: the closest point of a surface to a point.
//
// A BoxTree, split by the triangles' centroids. Where triangles are long and lie across the axes, as around a corner
// that very many have in common, their boxes all meet: then nodes store two slabs as well, across which their triangles
// are thin.
#pragma once

#include <array>

#include <cstdint>
#include <limits>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "mesh/box_tree.hpp"

namespace isoextract::mesh {

class TriangleTree {
 public:
  struct Corners {
    glm::vec3 a, b, c;
  };

  // What is nearest to a point. A slot is a triangle's number in the order of the tree.
  struct Nearest {
    double distance_squared = std::numeric_limits<double>::infinity();
    std::uint32_t slot = 0;
    glm::dvec3 point{0.0};
  };

  // What making the tree takes at most, for a caller to reserve; half of it, once it is made without slabs.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t triangles) {
    return triangles * sizeof(Corners) + BoxTree::bytes(triangles);
  }

  // At least one triangle; finite positions; indices below positions.size(). The tree keeps copies. It is the same for
  // any number of threads.
  TriangleTree(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles);

  // The nearest point of all triangles, in the frame of the positions. The search starts from what is known of the
  // triangle in slot `hint`: one that is near saves time, and wins where it is as near as another. What is as near as
  // `enough_squared` ends it, though something else may be nearer.
  [[nodiscard]] Nearest nearest(const glm::dvec3& p, std::uint32_t hint, double enough_squared = 0) const;

  // The nearest point of one triangle.
  [[nodiscard]] Nearest nearest_in(std::uint32_t slot, const glm::dvec3& p) const;

  // The greatest squared distance of the points to one triangle.
  [[nodiscard]] double farthest_squared_in(std::uint32_t slot, std::span<const glm::dvec3> points) const;

  [[nodiscard]] const Corners& corners(std::uint32_t slot) const { return corners_[slot]; }
  // The triangle in a slot, by its number among those that the tree was made of.
  [[nodiscard]] std::uint32_t triangle(std::uint32_t slot) const { return tree_.numbers()[slot]; }
  [[nodiscard]] std::size_t size() const { return corners_.size(); }
  [[nodiscard]] bool has_slabs() const { return !slabs_.empty(); }

  // How many leaves may hold something nearer than that: what the search for a point at this distance costs.
  [[nodiscard]] std::size_t leaves_within(const glm::dvec3& p, double squared) const;

 private:
  // The points p with low <= dot(axis, p) <= high, where no axis is longer than 1.
  struct Slab {
    std::array<std::int16_t, 3> axis{};  // in parts of kAxisOne
    float low = 0;
    float high = 0;
    [[nodiscard]] double along(const glm::dvec3& p) const;
    [[nodiscard]] double distance(const glm::dvec3& p) const;
  };

  void search_below(std::size_t node, double node_distance_squared, const glm::dvec3& p, double enough_squared,
                    Nearest& best) const;
  void search(std::size_t leaf, const glm::dvec3& p, Nearest& best) const;
  [[nodiscard]] bool boxes_are_loose() const;
  void make_slabs();
  [[nodiscard]] std::array<Slab, 2> slabs_of(const BoxTree::Node& node) const;
  // No point of the node's triangles is nearer.
  [[nodiscard]] double bound_squared(std::size_t node, const glm::dvec3& p) const;

  BoxTree tree_;
  Buffer<Corners> corners_;            // by slots
  Buffer<std::array<Slab, 2>> slabs_;  // of nodes above the leaves; none where boxes are tight
};

}  // namespace isoextract::mesh
