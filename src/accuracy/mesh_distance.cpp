#include "accuracy/mesh_distance.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "accuracy/detail/same_triangles.hpp"
#include "base/parallel.hpp"
#include "mesh/greatest_distance.hpp"
#include "mesh/metrics.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::accuracy {
namespace {

// Range ends depend on the size alone, and so do all search hints.
constexpr std::size_t kGrain = 512;

// Returns the n-th of evenly spread points in the unit square: the sequence R2 of M. Roberts, The unreasonable
// effectiveness of quasirandom sequences (2018).
glm::dvec2 spread(std::uint64_t n) {
  constexpr double kPlastic = 1.32471795724474602596;
  const double k = static_cast<double>(n + 1);
  const auto fraction = [](double x) { return x - std::floor(x); };
  return {fraction(k / kPlastic), fraction(k / (kPlastic * kPlastic))};
}

// Returns the limit of tree leaves for each of `triangles` triangles: an equal share of the total, but at least enough
// for a triangle whose bound depends only on its surroundings.
std::size_t max_leaves(std::size_t triangles) {
  constexpr std::size_t kTogether = std::size_t{1} << 26;
  constexpr std::size_t kLeast = std::size_t{1} << 16;
  constexpr std::size_t kMost = std::size_t{1} << 22;
  return std::clamp(kTogether / std::max<std::size_t>(triangles, 1), kLeast, kMost);
}

// One direction of the comparison: the points of A in the frame of B's tree.
class Direction {
 public:
  Direction(const mesh::Mesh& a, const mesh::Mesh& b, const mesh::TriangleTree& tree, const DistanceOptions& options,
            double floor, const Context& context)
      : a_(a),
        b_(b),
        tree_(tree),
        options_(options),
        shift_(a.origin - b.origin),
        common_(mark_common_triangles(a, b, shift_)),
        search_({a.positions.span(), a.triangles.span(), common_, shift_}, tree,
                {.tolerance = options.tolerance,
                 .floor = floor,
                 .enough = options.enough,
                 .max_leaves = max_leaves(a.triangles.size())},
                context) {}

  // Returns the peak memory, with the tree of B and with the samples, which outlive this object.
  [[nodiscard]] static std::uint64_t bytes(const mesh::Mesh& a, const mesh::Mesh& b, const DistanceOptions& options) {
    return mesh::TriangleTree::bytes(b.triangles.size()) + common_triangles_bytes(a, b) +
           mesh::GreatestDistanceSearch::bytes(a.positions.size(), a.triangles.size()) +
           options.samples * (4 * sizeof(double) + sizeof(glm::dvec3));
  }

  DirectedDistance measure() {
    search_.measure_corners();
    measure_samples();
    const mesh::GreatestDistance found = search_.bound_triangles();
    DirectedDistance result;
    result.max_lower = found.lower;
    result.max_upper = found.upper;
    result.place = found.place + b_.origin;
    result.nearest = found.nearest + b_.origin;
    return result;
  }

  std::vector<double>& samples() { return samples_; }

 private:
  [[nodiscard]] glm::dvec3 point(std::uint32_t vertex) const { return glm::dvec3(a_.positions[vertex]) + shift_; }

  // Sample k represents the k-th of equal shares of the area, so all samples have equal weight.
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
    for_each_fixed_range(samples_.size(), kGrain, [&](std::size_t first, std::size_t last) {
      std::uint32_t hint = 0;
      for (std::size_t k = first; k < last; ++k) {
        const double area = (static_cast<double>(k) + 0.5) * share;
        const auto after = std::upper_bound(area_up_to.begin() + 1, area_up_to.end() - 1, area);
        const auto triangle = static_cast<std::size_t>(after - area_up_to.begin() - 1);
        if (common_[triangle] != 0) continue;
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
    if (*farthest > search_.lower()) {
      search_.add_point(places[static_cast<std::size_t>(farthest - samples_.begin())], 0);
    }
  }

  const mesh::Mesh& a_;
  const mesh::Mesh& b_;
  const mesh::TriangleTree& tree_;
  const DistanceOptions& options_;
  glm::dvec3 shift_;
  std::vector<char> common_;  // 1: B has the triangle of A, too
  std::vector<double> samples_;
  mesh::GreatestDistanceSearch search_;
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

}  // namespace

Result<MeshDistance> measure_distance(const mesh::Mesh& a, const mesh::Mesh& b, const DistanceOptions& options,
                                      const Context& context) {
  for (const mesh::Mesh* mesh : {&a, &b}) {
    if (!mesh->triangles.empty()) continue;
    return fail(ErrorCode::input, fmt::format("{} mesh{} has no triangles, so there is no distance to it",
                                              mesh == &a ? "the first" : "the second",
                                              mesh->name.empty() ? "" : fmt::format(", {},", mesh->name)));
  }
  constexpr double kFarthest = 1e150;
  if (const double apart = glm::length(a.origin - b.origin); !(apart <= kFarthest)) {
    return fail(ErrorCode::input, fmt::format("expected mesh origins at most {:g} apart, found {:g} between {} and {}",
                                              kFarthest, apart, a.name, b.name));
  }
  const auto memory = TRY(context.reserve(std::max(Direction::bytes(a, b, options), Direction::bytes(b, a, options)),
                                          fmt::format("{} and {}: the distances of their triangles", a.name, b.name)));
  MeshDistance result;
  result.resolution =
      std::max(mesh::float32_resolution(a.positions.span()), mesh::float32_resolution(b.positions.span()));
  context.progress().begin("measuring distances", 0);
  const auto directed = [&](const mesh::Mesh& from, const mesh::Mesh& to, std::vector<double>& samples) {
    const mesh::TriangleTree tree(to.positions.span(), to.triangles.span());
    Direction direction(from, to, tree, options, result.resolution, context);
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
  TRY(context.check());
  result.hausdorff_lower = std::max(result.a_to_b.max_lower, result.b_to_a.max_lower);
  result.hausdorff_upper = std::max(result.a_to_b.max_upper, result.b_to_a.max_upper);
  samples.insert(samples.end(), more.begin(), more.end());
  const SampleFigures figures = figures_of(samples);
  result.rms = figures.rms;
  result.mean = figures.mean;
  result.percentile99 = figures.percentile99;
  return result;
}

}  // namespace isoextract::accuracy
