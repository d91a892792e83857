#include "measure/mesh_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <tbb/partitioner.h>

#include "measure/detail/same_triangles.hpp"
#include "mesh/distance_bound.hpp"
#include "mesh/metrics.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::measure {
namespace {

// The ends of the ranges follow from the size alone (simple_partitioner), and with them every hint.
constexpr std::size_t kGrain = 512;

template <class Body>
void for_ranges(std::size_t size, const Body& body) {
  const tbb::blocked_range<std::size_t> range(0, size, kGrain);
  tbb::parallel_for(
      range, [&](const tbb::blocked_range<std::size_t>& part) { body(part.begin(), part.end()); },
      tbb::simple_partitioner());
}

// Two coordinates in the unit square for the n-th sample, spread evenly: the sequence R2 of M. Roberts, The
// unreasonable effectiveness of quasirandom sequences (2018).
glm::dvec2 spread(std::uint64_t n) {
  constexpr double kPlastic = 1.32471795724474602596;
  const double k = static_cast<double>(n + 1);
  const auto fraction = [](double x) { return x - std::floor(x); };
  return {fraction(k / kPlastic), fraction(k / (kPlastic * kPlastic))};
}

// A's side of the comparison: its points in the frame of B's tree.
class Direction {
  struct Corner {
    double distance_squared = 0;
    std::uint32_t slot = 0;
  };
  struct Open {
    double upper;
    std::uint32_t triangle;
  };

 public:
  Direction(const mesh::Mesh& a, const mesh::Mesh& b, const mesh::TriangleTree& tree, const DistanceOptions& options,
            double floor)
      : a_(a),
        b_(b),
        tree_(tree),
        options_(options),
        shift_(a.origin - b.origin),
        in_both_(triangles_in_both(a, b, shift_)) {
    limits_.tolerance = options.tolerance;
    limits_.floor = floor;
    limits_.enough = options.enough;
  }

  // What it takes at most, with the tree of B, and the samples that outlive it.
  [[nodiscard]] static std::uint64_t bytes(const mesh::Mesh& a, const mesh::Mesh& b, const DistanceOptions& options) {
    const std::uint64_t a_triangle = sizeof(double) + sizeof(Open) + sizeof(mesh::TriangleBound);
    return mesh::TriangleTree::bytes(b.triangles.size()) + triangles_in_both_bytes(a, b) +
           a.positions.size() * (sizeof(Corner) + 1) + a.triangles.size() * a_triangle +
           options.samples * (4 * sizeof(double) + sizeof(glm::dvec3));
  }

  DirectedDistance measure() {
    measure_corners();
    measure_samples();
    bound_triangles();
    result_.max_upper = std::max(result_.max_upper, result_.max_lower);
    result_.place += b_.origin;
    result_.nearest += b_.origin;
    return result_;
  }

  std::vector<double>& samples() { return samples_; }

 private:
  [[nodiscard]] glm::dvec3 point(std::uint32_t vertex) const { return glm::dvec3(a_.positions[vertex]) + shift_; }

  void take(double distance, const glm::dvec3& place, const glm::dvec3& nearest) {
    if (distance <= result_.max_lower && has_place_) return;
    has_place_ = true;
    result_.max_lower = distance;
    result_.place = place;
    result_.nearest = nearest;
  }
  void take_nearest_of(const glm::dvec3& p, std::uint32_t hint) {
    const mesh::TriangleTree::Nearest nearest = tree_.nearest(p, hint);
    take(std::sqrt(nearest.distance_squared), p, nearest.point);
  }

  // Vertices that no triangle uses are no points of the surface; those that are used by triangles of both meshes alone
  // have the distance 0.
  void measure_corners() {
    std::vector<char> used(a_.positions.size(), 0);
    for (std::size_t i = 0; i < a_.triangles.size(); ++i) {
      const glm::uvec3& t = a_.triangles[i];
      if (in_both_[i] == 0) used[t.x] = used[t.y] = used[t.z] = 1;
    }
    corners_.resize(a_.positions.size());
    for_ranges(corners_.size(), [&](std::size_t first, std::size_t last) {
      std::uint32_t hint = 0;
      for (std::size_t v = first; v < last; ++v) {
        if (used[v] == 0) continue;
        const mesh::TriangleTree::Nearest nearest = tree_.nearest(point(static_cast<std::uint32_t>(v)), hint);
        corners_[v] = {nearest.distance_squared, nearest.slot};
        hint = nearest.slot;
      }
    });
    std::size_t farthest = a_.triangles[0].x;
    for (std::size_t v = 0; v < corners_.size(); ++v) {
      if (used[v] != 0 && corners_[v].distance_squared > corners_[farthest].distance_squared) farthest = v;
    }
    const glm::dvec3 place = point(static_cast<std::uint32_t>(farthest));
    if (used[farthest] != 0) {
      take_nearest_of(place, corners_[farthest].slot);
    } else {
      take(0, place, place);
    }
  }

  // Sample k stands for the k-th of equal shares of the area, so the samples have equal weights.
  void measure_samples() {
    if (options_.samples == 0) return;
    std::vector<double> area_up_to(a_.triangles.size() + 1, 0.0);
    for (std::size_t t = 0; t < a_.triangles.size(); ++t) {
      const glm::uvec3& triangle = a_.triangles[t];
      const glm::dvec3 a(a_.positions[triangle.x]);
      const glm::dvec3 normal =
          glm::cross(glm::dvec3(a_.positions[triangle.y]) - a, glm::dvec3(a_.positions[triangle.z]) - a);
      area_up_to[t + 1] = area_up_to[t] + glm::length(normal);
    }
    samples_.resize(options_.samples);
    const double share = area_up_to.back() / static_cast<double>(samples_.size());
    std::vector<glm::dvec3> places(samples_.size());
    for_ranges(samples_.size(), [&](std::size_t first, std::size_t last) {
      std::uint32_t hint = 0;
      for (std::size_t k = first; k < last; ++k) {
        const double area = (static_cast<double>(k) + 0.5) * share;
        const auto after = std::upper_bound(area_up_to.begin() + 1, area_up_to.end() - 1, area);
        const auto triangle = static_cast<std::size_t>(after - area_up_to.begin() - 1);
        if (in_both_[triangle] != 0) continue;
        const glm::uvec3& t = a_.triangles[triangle];
        glm::dvec2 uv = spread(k);
        if (uv.x + uv.y > 1) uv = glm::dvec2(1) - uv;
        places[k] = (1 - uv.x - uv.y) * point(t.x) + uv.x * point(t.y) + uv.y * point(t.z);
        const mesh::TriangleTree::Nearest nearest = tree_.nearest(places[k], hint);
        samples_[k] = std::sqrt(nearest.distance_squared);
        hint = nearest.slot;
      }
    });
    const auto farthest = std::max_element(samples_.begin(), samples_.end());
    if (*farthest > result_.max_lower) {
      take_nearest_of(places[static_cast<std::size_t>(farthest - samples_.begin())], 0);
    }
  }

  [[nodiscard]] double distance_squared(std::uint32_t vertex, std::uint32_t slot) const {
    return corners_[vertex].slot == slot ? corners_[vertex].distance_squared
                                         : tree_.nearest_in(slot, point(vertex)).distance_squared;
  }

  // What the triangles nearest to the corners say: no cut, no search.
  [[nodiscard]] double quick_upper(const glm::uvec3& t) const {
    double least = std::numeric_limits<double>::infinity();
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t slot = corners_[t[corner]].slot;
      double greatest = 0;
      for (int other = 0; other < 3; ++other) greatest = std::max(greatest, distance_squared(t[other], slot));
      least = std::min(least, greatest);
    }
    return std::sqrt(least);
  }

  // The widest bounds first, in rounds: what a round finds spares the next ones work, and no thread's luck decides
  // what is looked at.
  void bound_triangles() {
    std::vector<double> uppers(a_.triangles.size());
    for_ranges(uppers.size(), [&](std::size_t first, std::size_t last) {
      for (std::size_t t = first; t < last; ++t) uppers[t] = in_both_[t] != 0 ? 0 : quick_upper(a_.triangles[t]);
    });
    std::vector<Open> open;
    const double good = limits_.good_upper(result_.max_lower);
    for (std::size_t t = 0; t < uppers.size(); ++t) {
      if (uppers[t] <= good) {
        result_.max_upper = std::max(result_.max_upper, uppers[t]);
      } else {
        open.push_back({uppers[t], static_cast<std::uint32_t>(t)});
      }
    }
    tbb::parallel_sort(open.begin(), open.end(), [](const Open& x, const Open& y) {
      return x.upper != y.upper ? x.upper > y.upper : x.triangle < y.triangle;
    });
    std::size_t round = 256;
    std::vector<mesh::TriangleBound> bounds;
    for (std::size_t first = 0; first < open.size();) {
      if (open[first].upper <= limits_.good_upper(result_.max_lower)) {
        result_.max_upper = std::max(result_.max_upper, open[first].upper);
        break;  // it has the widest bound of those that are left
      }
      const std::size_t count = std::min(round, open.size() - first);
      bounds.assign(count, {});
      const double known = result_.max_lower;
      tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
        const glm::uvec3& t = a_.triangles[open[first + i].triangle];
        bounds[i] =
            mesh::bound_distance({point(t.x), point(t.y), point(t.z)}, tree_, limits_, known, corners_[t.x].slot);
      });
      for (const mesh::TriangleBound& bound : bounds) {
        take(bound.lower, bound.place, bound.nearest);
        result_.max_upper = std::max(result_.max_upper, bound.upper);
      }
      first += count;
      round *= 2;
    }
  }

  const mesh::Mesh& a_;
  const mesh::Mesh& b_;
  const mesh::TriangleTree& tree_;
  const DistanceOptions& options_;
  glm::dvec3 shift_;
  std::vector<char> in_both_;  // of A's triangles: B has it as well
  mesh::DistanceLimits limits_;
  std::vector<Corner> corners_;  // of A's vertices
  std::vector<double> samples_;
  bool has_place_ = false;
  DirectedDistance result_;
};

struct SampleFigures {
  double rms = 0;
  double mean = 0;
  double percentile99 = 0;
};

SampleFigures figures_of(std::vector<double>& samples) {
  if (samples.empty()) return {};
  SampleFigures figures;
  for (const double d : samples) {
    figures.rms += d * d;
    figures.mean += d;
  }
  const auto count = static_cast<double>(samples.size());
  figures.rms = std::sqrt(figures.rms / count);
  figures.mean /= count;
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(0.99 * count)) - 1;
  std::nth_element(samples.begin(), samples.begin() + rank, samples.end());
  figures.percentile99 = samples[static_cast<std::size_t>(rank)];
  return figures;
}

double float32_resolution(const mesh::Mesh& mesh) {
  const mesh::LocalBounds bounds = mesh::measure_local_bounds(mesh);
  const glm::vec3 farthest = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
  return static_cast<double>(std::max({farthest.x, farthest.y, farthest.z})) * 0x1p-23;
}

}  // namespace

Result<MeshDistance> measure_distance(const mesh::Mesh& a, const mesh::Mesh& b, const DistanceOptions& options,
                                      const Context& context) {
  for (const mesh::Mesh* mesh : {&a, &b}) {
    if (!mesh->triangles.empty()) continue;
    return fail(ErrorKind::input, fmt::format("{} mesh{} has no triangles, so there is no distance to it",
                                              mesh == &a ? "the first" : "the second",
                                              mesh->name.empty() ? "" : fmt::format(", {},", mesh->name)));
  }
  constexpr double kFarthest = 1e150;
  if (const double apart = glm::length(a.origin - b.origin); !(apart <= kFarthest)) {
    return fail(ErrorKind::input,
                fmt::format("expected meshes at most {:g} apart, found {} and {} farther from each other", kFarthest,
                            a.name, b.name));
  }
  const auto memory = context.reserve(std::max(Direction::bytes(a, b, options), Direction::bytes(b, a, options)),
                                      fmt::format("{} and {}: the distances of their triangles", a.name, b.name));
  if (!memory) return tl::unexpected(memory.error());
  MeshDistance result;
  result.resolution = std::max(float32_resolution(a), float32_resolution(b));
  context.progress().begin("measuring distances", 0);
  const auto directed = [&](const mesh::Mesh& from, const mesh::Mesh& to, std::vector<double>& samples) {
    const mesh::TriangleTree tree(to.positions.span(), to.triangles.span());
    Direction direction(from, to, tree, options, result.resolution);
    DirectedDistance distance = direction.measure();
    samples = std::move(direction.samples());
    const SampleFigures figures = figures_of(samples);
    distance.rms = figures.rms;
    distance.mean = figures.mean;
    distance.percentile99 = figures.percentile99;
    return distance;
  };
  std::vector<double> samples;
  std::vector<double> more;
  result.a_to_b = directed(a, b, samples);
  result.b_to_a = directed(b, a, more);
  result.hausdorff_lower = std::max(result.a_to_b.max_lower, result.b_to_a.max_lower);
  result.hausdorff_upper = std::max(result.a_to_b.max_upper, result.b_to_a.max_upper);
  samples.insert(samples.end(), more.begin(), more.end());
  const SampleFigures figures = figures_of(samples);
  result.rms = figures.rms;
  result.mean = figures.mean;
  result.percentile99 = figures.percentile99;
  return result;
}

}  // namespace isoextract::measure
