// How far a triangle is from a surface at most, and at least: an interval that holds the greatest distance of any of
// its points, not only of samples.
//
// The distance to one triangle b of the surface is a convex function, since b is convex; over a convex polygon it is
// therefore greatest at a corner. The greatest distance of a polygon's corners to b bounds that of the whole polygon to
// the surface. Where the bound is too wide, the polygon is cut along the sides of b (planes through its edges, at right
// angles to it), so that each part comes to lie over one triangle: branch and bound. Compare Tang, Lee, Kim:
// Interactive Hausdorff distance computation for general polygonal models. ACM Trans. Graph. 28(3), 2009, who bound by
// the same convexity and split at midpoints.
#pragma once

#include <array>
#include <limits>

#include <glm/glm.hpp>

#include "mesh/triangle_tree.hpp"

namespace isoextract::mesh {

struct DistanceLimits {
  double tolerance = 0.01;  // the interval may be this wide, as a fraction of its lower end,
  double floor = 0;         // and this wide in any case
  double enough = 0;        // upper ends up to this need no cutting
  double refuse = std::numeric_limits<double>::infinity();  // a lower end above this ends the search: upper is infinite
  std::size_t most_parts = std::size_t{1} << 22;            // so many parts of one triangle end it, too,
  // and so many leaves of the tree that were looked at for them, about. Where a surface is as far everywhere, each part
  // looks at all.
  std::size_t most_leaves = std::numeric_limits<std::size_t>::max();

  // Upper ends up to this need no cutting where distances up to `lower` are known.
  [[nodiscard]] double good_upper(double lower) const {
    const double good = lower * (1 + tolerance) + floor;
    return good > enough ? good : enough;
  }
};

struct TriangleBound {
  double lower = 0;       // the distance of some point of the triangle: `place`
  double upper = 0;       // no point of the triangle is farther
  glm::dvec3 place{0.0};  // in the frame of the tree, as the nearest point
  glm::dvec3 nearest{0.0};
  std::uint32_t slot = 0;   // of the tree: nearest to the centroid of the triangle
  bool unfinished = false;  // ended by `refuse`, or after very many parts: wider than it should be, but it holds
};

// `known` is a distance that occurs anyway, elsewhere: below it nothing needs to be told apart. `hint` is a slot of the
// tree, near if possible. In double; its rounding is not accounted for: some 1e-16 of the coordinates, and up to 1e-8
// of the size of a triangle that is all but a line.
[[nodiscard]] TriangleBound bound_distance(const std::array<glm::dvec3, 3>& corners, const TriangleTree& tree,
                                           const DistanceLimits& limits, double known, std::uint32_t hint);

}  // namespace isoextract::mesh
