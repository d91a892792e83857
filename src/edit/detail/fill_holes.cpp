#include "edit/detail/fill_holes.hpp"

#include <algorithm>
#include <limits>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "mesh/adjacency.hpp"
#include "mesh/components.hpp"
#include "mesh/exact_sign.hpp"

namespace isoextract::edit {
namespace {

using Loop = std::vector<std::uint32_t>;  // vertices in the direction of the new triangles

// Returns the boundary loops, each without a repeated vertex.
std::vector<Loop> boundary_loops(std::size_t vertices, const EdgeUses& uses) {
  struct Side {
    std::uint32_t from, to;
  };
  std::vector<Side> sides;  // boundary edges, in the direction of the new triangles
  uses.for_each_edge([&](std::span<const EdgeUse> edge) {
    if (edge.size() == 1) sides.push_back({edge[0].to(), edge[0].from()});
  });
  std::ranges::sort(sides, {}, [](const Side& side) { return std::tie(side.from, side.to); });
  std::vector<bool> used(sides.size());
  const auto next_from = [&](std::uint32_t vertex) {
    const auto first = std::ranges::lower_bound(sides, vertex, {}, &Side::from) - sides.begin();
    auto at = static_cast<std::size_t>(first);
    while (at < sides.size() && sides[at].from == vertex && used[at]) ++at;
    return at < sides.size() && sides[at].from == vertex ? at : sides.size();
  };
  std::vector<Loop> loops;
  std::vector<bool> on_way(vertices);
  for (std::size_t start = 0; start < sides.size(); ++start) {
    if (used[start]) continue;
    Loop way{sides[start].from};
    on_way[way.back()] = true;
    for (std::size_t at = start; at < sides.size(); at = next_from(way.back())) {
      used[at] = true;
      const std::uint32_t to = sides[at].to;
      if (!on_way[to]) {
        way.push_back(to);
        on_way[to] = true;
        continue;
      }
      const auto first = std::ranges::find(way, to);
      Loop loop(first, way.end());
      for (const std::uint32_t v : loop) on_way[v] = v == to;
      way.erase(first + 1, way.end());
      if (loop.size() > 2) loops.push_back(std::move(loop));
    }
    for (const std::uint32_t v : way) on_way[v] = false;
  }
  return loops;
}

// The least cost of the triangles between two vertices of a loop.
struct Cost {
  std::uint32_t bad = 0;  // triangles without area, plus edges that the mesh has already
  double size = 0;        // area, plus a small weight for the lengths of the new edges

  friend bool operator<(const Cost& a, const Cost& b) { return std::tie(a.bad, a.size) < std::tie(b.bad, b.size); }
  Cost operator+(const Cost& other) const { return {bad + other.bad, size + other.size}; }
};

class LoopFiller {
 public:
  LoopFiller(const mesh::Mesh& mesh, const EdgeUses& uses, const Loop& loop)
      : loop_(loop), count_(loop.size()), costs_(count_ * count_), middles_(count_ * count_) {
    for (const std::uint32_t v : loop) points_.emplace_back(mesh.positions[v]);
    for (std::size_t length = 2; length < count_; ++length) {
      for (std::size_t first = 0; first + length < count_; ++first) choose(uses, first, first + length);
    }
  }

  // Returns the triangles, and their area.
  [[nodiscard]] std::pair<std::vector<glm::uvec3>, double> triangles() const {
    std::vector<glm::uvec3> made;
    double area = 0;
    std::vector<std::pair<std::size_t, std::size_t>> waiting{{0, count_ - 1}};
    while (!waiting.empty()) {
      const auto [first, last] = waiting.back();
      waiting.pop_back();
      if (last - first < 2) continue;
      const std::size_t middle = middles_[first * count_ + last];
      made.emplace_back(loop_[first], loop_[middle], loop_[last]);
      area += area_of(first, middle, last);
      waiting.emplace_back(first, middle);
      waiting.emplace_back(middle, last);
    }
    return {std::move(made), area};
  }

 private:
  // Chooses the third corner of the triangle at the edge from `first` to `last`.
  void choose(const EdgeUses& uses, std::size_t first, std::size_t last) {
    constexpr double kShortEdges = 1e-3;  // weight of a squared length beside an area
    const bool is_rim = first == 0 && last + 1 == count_;
    const glm::dvec3 edge = points_[last] - points_[first];
    Cost own{0, is_rim ? 0 : kShortEdges * glm::dot(edge, edge)};
    if (!is_rim && !uses.of_edge(loop_[first], loop_[last]).empty()) own.bad = 1;
    Cost best{std::numeric_limits<std::uint32_t>::max(), 0};
    for (std::size_t middle = first + 1; middle < last; ++middle) {
      const double area = area_of(first, middle, last);
      const bool flat = mesh::are_collinear(points_[first], points_[middle], points_[last]);
      const Cost cost = costs_[first * count_ + middle] + costs_[middle * count_ + last] + Cost{flat ? 1U : 0U, area};
      if (!(cost < best)) continue;
      best = cost;
      middles_[first * count_ + last] = static_cast<std::uint32_t>(middle);
    }
    costs_[first * count_ + last] = best + own;
  }

  [[nodiscard]] double area_of(std::size_t a, std::size_t b, std::size_t c) const {
    return glm::length(glm::cross(points_[b] - points_[a], points_[c] - points_[a])) / 2;
  }

  const Loop& loop_;
  std::size_t count_;
  std::vector<glm::dvec3> points_;
  std::vector<Cost> costs_;  // cost of the triangles between two vertices; row by row
  std::vector<std::uint32_t> middles_;
};

std::vector<double> component_areas(const mesh::Mesh& mesh, const mesh::Components& components) {
  std::vector<double> areas(components.count());
  for (const glm::uvec3& t : mesh.triangles) {
    if (mesh::has_repeated_index(t)) continue;
    const glm::dvec3 a(mesh.positions[t.x]);
    areas[components.of_vertex(t.x)] +=
        glm::length(glm::cross(glm::dvec3(mesh.positions[t.y]) - a, glm::dvec3(mesh.positions[t.z]) - a)) / 2;
  }
  return areas;
}

}  // namespace

Result<FillFigures> fill_holes(mesh::Mesh& mesh, const EdgeUses& uses, std::uint64_t most_edges,
                               const Context& context) {
  constexpr double kMostOfComponent = 0.75;
  FillFigures figures;
  const std::vector<Loop> loops = boundary_loops(mesh.positions.size(), uses);
  if (loops.empty()) return figures;
  const std::string what = mesh.name + ": filling its holes";
  const auto memory = TRY(context.reserve(
      mesh::Components::bytes(mesh.positions.size()) + most_edges * most_edges * (sizeof(Cost) + sizeof(std::uint32_t)),
      what));
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  const std::vector<double> areas = component_areas(mesh, components);
  std::vector<glm::uvec3> added;
  for (const Loop& loop : loops) {
    TRY(context.check());
    if (loop.size() > most_edges) {
      ++figures.left;
      ++figures.too_long;
      continue;
    }
    auto [triangles, area] = LoopFiller(mesh, uses, loop).triangles();
    if (!(area < kMostOfComponent * areas[components.of_vertex(loop.front())])) {
      ++figures.left;
      continue;
    }
    ++figures.filled;
    added.insert(added.end(), triangles.begin(), triangles.end());
  }
  figures.triangles = added.size();
  if (added.empty()) return figures;
  auto more = TRY(context.reserve(added.size() * sizeof(glm::uvec3), what));
  Buffer<glm::uvec3> all(mesh.triangles.size() + added.size());
  std::ranges::copy(mesh.triangles, all.begin());
  std::ranges::copy(added, all.begin() + mesh.triangles.size());
  mesh.triangles = std::move(all);
  mesh.memory.take(std::move(more));
  return figures;
}

}  // namespace isoextract::edit
