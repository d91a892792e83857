// Bounds the greatest distance of any point of a triangle from a surface by an interval, not only at samples.
//
// The given triangle is cut into convex polygons. The distance to a triangle b of the surface is a convex function, so
// over a polygon it is greatest at a corner. No point of the polygon is therefore farther from the surface than the
// polygon's farthest corner is from b. If the bound is too wide, the polygon is cut along a side of b (a plane through
// an edge of b, perpendicular to b), so that each part lies over one triangle. A polygon that lies over b already is
// halved. If some distance is near enough, cuts lie outside of the sides of b, which leaves fewer parts. This is branch
// and bound. Compare Tang, Lee, Kim: Interactive Hausdorff distance computation for general polygonal models. ACM
// Trans. Graph. 28(3), 2009. They use the same convexity and split at midpoints.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include <glm/glm.hpp>

#include "mesh/triangle_tree.hpp"

namespace isoextract::mesh {

struct DistanceLimits {
  double tolerance = 0.01;  // accepted width of the interval, as a fraction of its lower end,
  double floor = 0;         // plus this width
  double enough = 0;        // upper ends up to this are always accepted
  double refuse = std::numeric_limits<double>::infinity();  // a greater lower end stops the search: upper is infinite
  // The greatest number of parts of one triangle, and of visited leaves of the tree (estimated at every 64th part).
  // Where a surface is equally far everywhere, each part visits all leaves. Beyond a limit, upper is infinite if
  // `refuse` is finite. Otherwise the search divides no more parts, and the interval stays wider.
  std::size_t max_parts = std::size_t{1} << 22;
  std::size_t max_leaves = std::numeric_limits<std::size_t>::max();

  // Returns the upper end that is accepted if distances up to `lower` are known.
  [[nodiscard]] double accepted_upper(double lower) const {
    const double good = lower * (1 + tolerance) + floor;
    return good > enough ? good : enough;
  }
};

struct TriangleBound {
  double lower = 0;       // the distance of `place`, a point of the triangle; if 0, `place` and `nearest` are not set
  double upper = 0;       // an upper bound for all points of the triangle
  glm::dvec3 place{0.0};  // in the frame of the tree, like `nearest`
  glm::dvec3 nearest{0.0};
  std::uint32_t slot = 0;   // of the tree: `hint`, or the triangle nearest to the centroid if the search looked for it
  bool unfinished = false;  // stopped by `refuse` or a limit: the interval is valid but wider than requested
};

// Bounds the distance of a triangle from the surface in `tree`. `known` is a distance already found at another
// triangle, or 0: an upper end up to limits.accepted_upper(known) is accepted, however wide the interval. `hint` is a
// slot of the tree, preferably near. `others` are slots that may be near parts of the triangle. They save searches, but
// the lower end of the interval may be lower. Pass them only if neither the hint nor any of them is within
// limits.enough of the whole triangle: the search first cuts the triangle.
//
// Computes in double and ignores rounding: about 1e-16 of the coordinates, up to 1e-8 of the size of an almost
// degenerate triangle.
[[nodiscard]] TriangleBound bound_distance(const std::array<glm::dvec3, 3>& corners, const TriangleTree& tree,
                                           const DistanceLimits& limits, double known, std::uint32_t hint,
                                           std::span<const std::uint32_t> others = {});

}  // namespace isoextract::mesh
