#include "mesh/greatest_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <tbb/parallel_sort.h>

#include "base/parallel.hpp"

namespace isoextract::mesh {
namespace {

// The ranges depend on the size only, and so do all hints.
template <class Body>
void for_distance_ranges(std::size_t size, const Context& context, const Body& body) {
  constexpr std::size_t kGrain = 512;
  for_each_fixed_range(size, kGrain, [&](std::size_t begin, std::size_t end) {
    if (!context.cancelled()) body(begin, end);
  });
}

}  // namespace

GreatestDistanceSearch::GreatestDistanceSearch(const PlacedTriangles& from, const TriangleTree& to,
                                               const DistanceLimits& limits, const Context& context)
    : from_(from), to_(to), limits_(limits), context_(context) {}

void GreatestDistanceSearch::take(double distance, const glm::dvec3& place, const glm::dvec3& nearest) {
  if (distance <= found_.lower && has_place_) return;
  has_place_ = true;
  found_.lower = distance;
  found_.place = place;
  found_.nearest = nearest;
}

void GreatestDistanceSearch::add_point(const glm::dvec3& p, std::uint32_t hint) {
  const TriangleTree::Nearest nearest = to_.nearest(p, hint);
  take(std::sqrt(nearest.distance_squared), p, nearest.point);
}

void GreatestDistanceSearch::measure_corners() {
  std::vector<char> used(from_.positions.size(), 0);
  for (std::size_t i = 0; i < from_.triangles.size(); ++i) {
    const glm::uvec3& t = from_.triangles[i];
    if (counts(i)) used[t.x] = used[t.y] = used[t.z] = 1;
  }
  corners_.resize(from_.positions.size());
  for_distance_ranges(corners_.size(), context_, [&](std::size_t first, std::size_t last) {
    std::uint32_t hint = 0;
    for (std::size_t v = first; v < last; ++v) {
      if (used[v] == 0) continue;
      const TriangleTree::Nearest nearest = to_.nearest(point(static_cast<std::uint32_t>(v)), hint);
      corners_[v] = {nearest.distance_squared, nearest.slot};
      hint = nearest.slot;
    }
  });
  std::size_t farthest = from_.triangles[0].x;
  for (std::size_t v = 0; v < corners_.size(); ++v) {
    if (used[v] != 0 && corners_[v].distance_squared > corners_[farthest].distance_squared) farthest = v;
  }
  const glm::dvec3 place = point(static_cast<std::uint32_t>(farthest));
  if (used[farthest] != 0) {
    add_point(place, corners_[farthest].slot);
  } else {
    take(0, place, place);
  }
}

double GreatestDistanceSearch::distance_squared(std::uint32_t vertex, std::uint32_t slot) const {
  return corners_[vertex].slot == slot ? corners_[vertex].distance_squared
                                       : to_.nearest_on_triangle(slot, point(vertex)).distance_squared;
}

// Returns an upper bound from the triangles nearest to the corners, without cutting or searching.
double GreatestDistanceSearch::upper_bound_by_corners(const glm::uvec3& t) const {
  double least = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 3; ++corner) {
    const std::uint32_t slot = corners_[t[corner]].slot;
    double greatest = 0;
    for (int other = 0; other < 3; ++other) greatest = std::max(greatest, distance_squared(t[other], slot));
    least = std::min(least, greatest);
  }
  return std::sqrt(least);
}

GreatestDistance GreatestDistanceSearch::bound_triangles() {
  std::vector<double> uppers(from_.triangles.size());
  for_distance_ranges(uppers.size(), context_, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) uppers[t] = counts(t) ? upper_bound_by_corners(from_.triangles[t]) : 0;
  });
  std::vector<Open> open;
  const double good = limits_.accepted_upper(found_.lower);
  for (std::size_t t = 0; t < uppers.size(); ++t) {
    if (uppers[t] <= good) {
      found_.upper = std::max(found_.upper, uppers[t]);
    } else {
      open.push_back({uppers[t], static_cast<std::uint32_t>(t)});
    }
  }
  tbb::parallel_sort(open.begin(), open.end(), [](const Open& x, const Open& y) {
    return x.upper != y.upper ? x.upper > y.upper : x.triangle < y.triangle;
  });
  std::size_t round = 256;
  std::vector<TriangleBound> bounds;
  for (std::size_t first = 0; first < open.size() && !context_.cancelled();) {
    if (open[first].upper <= limits_.accepted_upper(found_.lower)) {
      found_.upper = std::max(found_.upper, open[first].upper);
      break;  // all following ones have smaller bounds
    }
    const std::size_t count = std::min(round, open.size() - first);
    bounds.assign(count, {});
    const double known = found_.lower;
    for_each_index(count, [&](std::size_t i) {
      if (context_.cancelled()) return;
      const glm::uvec3& t = from_.triangles[open[first + i].triangle];
      bounds[i] = bound_distance({point(t.x), point(t.y), point(t.z)}, to_, limits_, known, corners_[t.x].slot);
    });
    for (const TriangleBound& bound : bounds) {
      take(bound.lower, bound.place, bound.nearest);
      found_.upper = std::max(found_.upper, bound.upper);
    }
    first += count;
    round *= 2;
  }
  found_.upper = std::max(found_.upper, found_.lower);
  return found_;
}

}  // namespace isoextract::mesh
