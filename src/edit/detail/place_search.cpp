#include "edit/detail/place_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "edit/detail/edge_across.hpp"

namespace isoextract::edit {
namespace {

constexpr int kDirections = 64;
constexpr std::array kDistances{0.03, 0.1, 0.3, 0.5, 0.7, 0.95};  // lengths in the space of SearchLimits::to_metric
constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();

// Returns directions spread evenly over the sphere: a Fibonacci lattice. None lies along an axis of the grid.
std::array<glm::dvec3, kDirections> directions() {
  std::array<glm::dvec3, kDirections> all{};
  for (int i = 0; i < kDirections; ++i) {
    const double height = 1 - (2 * i + 1.0) / kDirections;
    const double angle = 2 * std::numbers::pi * i / std::numbers::phi;
    const double radius = std::sqrt(1 - height * height);
    all[static_cast<std::size_t>(i)] = {radius * std::cos(angle), radius * std::sin(angle), height};
  }
  return all;
}

}  // namespace

PlaceSearch::PlaceSearch(mesh::Mesh& mesh, const Signal& signal, std::span<const glm::vec3> before,
                         const SearchLimits& limits)
    : mesh_(mesh),
      signal_(signal),
      before_(before),
      limits_(limits),
      from_metric_(glm::inverse(limits.to_metric)),
      around_(mesh.triangles.span(), mesh.positions.size()),
      counter_(mesh),
      changed_(mesh.positions.size(), 0) {}

std::vector<PairCounter::Triangle> PlaceSearch::star_of(std::uint32_t vertex) const {
  std::vector<PairCounter::Triangle> star;
  for (const mesh::Corner corner : around_.corners(vertex)) {
    const auto t = static_cast<std::uint32_t>(mesh::triangle_of(corner));
    star.push_back({t, mesh_.triangles[t]});
  }
  return star;
}

// Returns the position of the vertex that leaves the fewest pairs, fewer than `fewest`; does not move the vertex.
// Measures the move from `origin`.
std::optional<PlaceSearch::Found> PlaceSearch::find_place(std::uint32_t vertex, std::uint8_t bound,
                                                          const glm::vec3& origin,
                                                          std::span<const PairCounter::Triangle> star,
                                                          std::size_t fewest) {
  static const std::array kAll = directions();
  const glm::vec3 here = mesh_.positions[vertex];
  std::optional<Found> found;
  for (const double distance : kDistances) {
    for (const glm::dvec3& direction : kAll) {
      if (fewest == 0) break;
      const glm::vec3 place(glm::dvec3(here) + signal_.allowed_part(bound, from_metric_ * (distance * direction)));
      const double move = glm::length(limits_.to_metric * (glm::dvec3(place) - glm::dvec3(origin)));
      if (place == here || !(move <= limits_.most_move)) continue;
      mesh_.positions[vertex] = place;
      if (!std::ranges::all_of(star, [&](const auto& t) { return counter_.has_area(t.corners); })) continue;
      if (counter_.is_taken(vertex)) continue;
      const std::size_t pairs = counter_.count(star, fewest);
      if (pairs >= fewest) continue;
      fewest = pairs;
      found = Found{place, pairs};
    }
  }
  mesh_.positions[vertex] = here;
  return found;
}

std::optional<PlaceSearch::Move> PlaceSearch::best_move(std::uint32_t vertex) {
  // Testing a position takes time quadratic in the number of triangles, so vertices with many triangles stay.
  constexpr std::size_t kMostTriangles = 64;
  if (signal_.constraints(vertex) >= kFixed || around_.corners(vertex).size() > kMostTriangles) return std::nullopt;
  const std::vector<PairCounter::Triangle> star = star_of(vertex);
  const std::size_t before = counter_.count(star, kAnyNumber);
  const auto found = find_place(vertex, signal_.constraints(vertex), before_[vertex], star, before);
  if (!found) return std::nullopt;
  return Move{vertex, found->place, before - found->pairs};
}

std::size_t PlaceSearch::move_vertices(Pairs pairs, const Context& context) {
  std::size_t moves = 0;
  for (const auto& pair : pairs) {
    if (!context.check()) break;
    const auto best =
        best_of_pair(pair, [&](std::uint32_t t, int corner) { return best_move(mesh_.triangles[t][corner]); });
    if (!best) continue;
    mesh_.positions[best->vertex] = best->place;
    for (const auto& t : star_of(best->vertex)) counter_.update(t.number);
    ++moves;
  }
  return moves;
}

// Returns the split of the edge that starts at this corner; nothing unless it leaves fewer pairs.
std::optional<PlaceSearch::Split> PlaceSearch::split_at(std::uint32_t t, int corner, std::uint32_t spare,
                                                        std::uint32_t half) {
  const glm::uvec3 own = mesh_.triangles[t];
  const std::uint32_t a = own[corner];
  const std::uint32_t b = own[(corner + 1) % 3];
  const std::uint32_t c = own[(corner + 2) % 3];
  const auto other_corner = find_corner_across(mesh_, around_, a, b);
  if (!other_corner) return std::nullopt;
  const auto other = static_cast<std::uint32_t>(mesh::triangle_of(*other_corner));
  const glm::uvec3 others = mesh_.triangles[other];
  const std::uint32_t d = others[static_cast<int>((*other_corner % 3 + 2) % 3)];
  for (const std::uint32_t v : {a, b, c, d}) {
    if (changed_[v] != 0 || signal_.constraints(v) >= kFixed) return std::nullopt;
  }
  const std::array before{PairCounter::Triangle{t, own}, PairCounter::Triangle{other, others}};
  const std::size_t pairs = counter_.count(before, kAnyNumber);
  Split split{{a, b},
              {PairCounter::Triangle{t, {a, spare, c}}, PairCounter::Triangle{other, {b, spare, d}},
               PairCounter::Triangle{half, {spare, b, c}}, PairCounter::Triangle{half + 1, {spare, a, d}}},
              {},
              0};
  const glm::vec3 origin(0.5 * (glm::dvec3(before_[a]) + glm::dvec3(before_[b])));
  mesh_.positions[spare] = glm::vec3(0.5 * (glm::dvec3(mesh_.positions[a]) + glm::dvec3(mesh_.positions[b])));
  const auto bound = static_cast<std::uint8_t>(signal_.sides_of(own) | signal_.sides_of(others));
  const auto found = find_place(spare, bound, origin, split.after, pairs);
  if (!found) return std::nullopt;
  split.place = found->place;
  split.gain = pairs - found->pairs;
  return split;
}

std::vector<std::array<std::uint32_t, 2>> PlaceSearch::split_edges(Pairs pairs, std::uint32_t first_spare,
                                                                   std::uint32_t first_half, const Context& context) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const auto& pair : pairs) {
    if (!context.check()) break;
    const auto spare = static_cast<std::uint32_t>(first_spare + edges.size());
    const auto half = static_cast<std::uint32_t>(first_half + 2 * edges.size());
    const auto best = best_of_pair(pair, [&](std::uint32_t t, int corner) { return split_at(t, corner, spare, half); });
    if (!best) continue;
    mesh_.positions[spare] = best->place;
    for (const PairCounter::Triangle& t : best->after) {
      mesh_.triangles[t.number] = t.corners;
      counter_.update(t.number);
      for (int corner = 0; corner < 3; ++corner) changed_[t.corners[corner]] = 1;
    }
    edges.push_back(best->edge);
  }
  return edges;
}

}  // namespace isoextract::edit
