#include "mesh/self_intersections.hpp"

#include <algorithm>
#include <atomic>
#include <new>
#include <numeric>
#include <string>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>

#include "base/allocation_error.hpp"
#include "mesh/detail/triangle_boxes.hpp"
#include "mesh/detail/unique_triangles.hpp"
#include "mesh/triangle_overlap.hpp"

namespace isoextract::mesh {
namespace {

using TrianglePair = std::array<std::uint32_t, 2>;

// The results of one thread.
struct FoundPairs {
  std::uint64_t looked_at = 0;
  std::uint64_t pairs = 0;
  std::uint64_t in_one_plane = 0;
  std::uint64_t neighbors = 0;
  std::vector<TrianglePair> first;  // heap with the last of the first pairs on top

  void add_example(const TrianglePair& pair, std::size_t most) {
    if (most == 0 || (first.size() == most && first.front() < pair)) return;
    if (first.size() == most) {
      std::ranges::pop_heap(first);
      first.pop_back();
    }
    first.push_back(pair);
    std::ranges::push_heap(first);
  }
};

class IntersectionSearch {
 public:
  IntersectionSearch(const Mesh& mesh, const IntersectionOptions& options, const Context& context)
      : mesh_(mesh),
        options_(options),
        context_(context),
        places_(mesh.positions.span()),
        distinct_(find_unique_triangles(mesh.positions.span(), mesh.triangles.span(), places_)) {}

  // Returns the peak memory.
  [[nodiscard]] static std::uint64_t bytes(const Mesh& mesh) {
    const std::uint64_t triangles = mesh.triangles.size();
    return CoincidentVertices::bytes(mesh.positions.size()) + CrowdedStars::bytes(mesh.positions.size()) +
           std::max(distinct_triangle_bytes(triangles),
                    triangles * (2 * sizeof(std::uint32_t) + 1) + TriangleBoxes::bytes(triangles));
  }

  Result<SelfIntersections> run() {
    result_.zero_area_triangles = distinct_.zero_area;
    result_.duplicate_triangles = distinct_.duplicates;
    if (distinct_.triangles.empty()) return result_;
    const CrowdedStars stars(mesh_.positions.span(), distinct_.triangles.span(),
                             [&](std::uint32_t triangle) { return places_.of_triangle(mesh_.triangles[triangle]); });
    const std::uint64_t count = stars.empty() ? 0 : mesh_.triangles.size();
    const auto memory = TRY(context_.reserve(CrowdedStars::crowded_bytes(count) + TriangleBoxes::star_bytes(count),
                                             mesh_.name + ": corners with many triangles"));
    const TriangleBoxes boxes(mesh_.positions.span(), mesh_.triangles.span(), distinct_.triangles.span(), stars);
    met_ = Buffer<std::uint8_t>(mesh_.triangles.size());
    std::fill(met_.begin(), met_.end(), std::uint8_t{0});
    boxes.for_each_near_pair(
        stopped_, [&](std::uint32_t i, std::uint32_t j) { look_at(i, j); },
        [&](std::size_t triangles) { advance(triangles); });
    TRY(context_.check());
    if (total_.load() > options_.most_pairs) {
      result_.at_least = true;
      result_.pairs = options_.most_pairs;
      TRY(find_examples(boxes));
      return result_;
    }
    gather();
    return result_;
  }

 private:
  [[nodiscard]] PlacedTriangle placed(std::uint32_t triangle) const {
    const glm::uvec3& t = mesh_.triangles[triangle];
    return {{glm::dvec3(mesh_.positions[t.x]), glm::dvec3(mesh_.positions[t.y]), glm::dvec3(mesh_.positions[t.z])}};
  }

  [[nodiscard]] std::uint64_t copies_of(std::uint32_t triangle) const {
    if (distinct_.duplicates == 0) return 1;
    const auto found = std::ranges::lower_bound(distinct_.triangles, triangle);
    return distinct_.copies[static_cast<std::size_t>(found - distinct_.triangles.begin())];
  }

  void mark(std::uint32_t triangle) { std::atomic_ref(met_[triangle]).store(1, std::memory_order_relaxed); }

  void look_at(std::uint32_t i, std::uint32_t j) {
    if (context_.cancelled()) stopped_.store(true, std::memory_order_relaxed);
    FoundPairs& found = found_.local();
    ++found.looked_at;
    const TriangleOverlap overlap = find_overlap(placed(i), placed(j));
    if (!overlap.meet) return;
    const std::uint64_t pairs = copies_of(i) * copies_of(j);
    found.pairs += pairs;
    found.in_one_plane += overlap.in_one_plane ? pairs : 0;
    found.neighbors += overlap.neighbors ? pairs : 0;
    found.add_example({std::min(i, j), std::max(i, j)}, options_.examples);
    mark(i);
    mark(j);
    if (total_.fetch_add(pairs, std::memory_order_relaxed) + pairs > options_.most_pairs) stopped_.store(true);
  }

  void advance(std::size_t triangles) {
    context_.progress().advance(triangles);
    if (context_.cancelled()) stopped_.store(true);
  }

  void gather() {
    FoundPairs all;
    for (const FoundPairs& part : found_) {
      all.looked_at += part.looked_at;
      all.pairs += part.pairs;
      all.in_one_plane += part.in_one_plane;
      all.neighbors += part.neighbors;
      for (const TrianglePair& pair : part.first) all.add_example(pair, options_.examples);
    }
    std::ranges::sort(all.first);
    result_.looked_at = all.looked_at;
    result_.pairs = all.pairs;
    result_.in_one_plane = all.in_one_plane;
    result_.neighbors = all.neighbors;
    result_.examples = std::move(all.first);
    result_.triangles = std::accumulate(met_.begin(), met_.end(), std::uint64_t{0});
  }

  // After an early stop, the pairs found depend on the threads, so this finds the first pairs again, one by one.
  Result<void> find_examples(const TriangleBoxes& boxes) {
    for (const std::uint32_t i : distinct_.triangles) {
      if (result_.examples.size() == options_.examples) break;
      TRY(context_.check());
      FoundPairs found;
      const PlacedTriangle first = placed(i);
      boxes.for_each_near(boxes.box_of(i), [&](std::uint32_t j) {
        if (j > i && find_overlap(first, placed(j)).meet) {
          found.add_example({i, j}, options_.examples - result_.examples.size());
        }
      });
      std::ranges::sort(found.first);
      result_.examples.insert(result_.examples.end(), found.first.begin(), found.first.end());
    }
    return {};
  }

  const Mesh& mesh_;
  const IntersectionOptions& options_;
  const Context& context_;
  CoincidentVertices places_;
  UniqueTriangles distinct_;
  Buffer<std::uint8_t> met_;  // 1: the triangle is in a pair
  std::atomic<bool> stopped_{false};
  std::atomic<std::uint64_t> total_{0};
  tbb::enumerable_thread_specific<FoundPairs> found_;
  SelfIntersections result_;
};

}  // namespace

Result<SelfIntersections> find_self_intersections(const Mesh& mesh, const IntersectionOptions& options,
                                                  const Context& context) {
  const std::string what = fmt::format("{}: the search for self-intersections", mesh.name);
  const auto memory = TRY(context.reserve(IntersectionSearch::bytes(mesh), what));
  try {
    context.progress().begin("looking for self-intersections", mesh.triangles.size());
    return IntersectionSearch(mesh, options, context).run();
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " needs more memory than is available"));
  }
}

}  // namespace isoextract::mesh
