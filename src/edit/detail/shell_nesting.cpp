#include "edit/detail/shell_nesting.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/spin_mutex.h>

#include "mesh/adjacency.hpp"

namespace isoextract::edit {
namespace {

using mesh::Components;

// Along no line that vertices of a grid have in common.
const glm::dvec3 kAlong = glm::normalize(glm::dvec3(0.8112, 0.4361, 0.3897));
const glm::dvec3 kAcross = glm::normalize(glm::cross(kAlong, glm::dvec3(0, 0, 1)));
const glm::dvec3 kUp = glm::cross(kAlong, kAcross);

// A place seen along the rays: across them, and how far along.
struct Seen {
  double u = 0;
  double v = 0;
  double along = -std::numeric_limits<double>::infinity();
};

Seen seen(const glm::dvec3& p) { return {glm::dot(p, kAcross), glm::dot(p, kUp), glm::dot(p, kAlong)}; }

// Twice the area of the triangle abp: exactly the negative of that of bap, so that a point on an edge is in one of the
// two triangles at least.
double turn(const Seen& a, const Seen& b, const Seen& p) {
  return (a.u - p.u) * (b.v - p.v) - (b.u - p.u) * (a.v - p.v);
}

struct Hit {
  double along = std::numeric_limits<double>::infinity();
  std::size_t triangle = 0;
};

// The first places where the rays meet triangles of other components.
class Rays {
 public:
  Rays(const Components& components, std::vector<Seen> starts)
      : components_(components), starts_(std::move(starts)), hits_(starts_.size()), locks_(starts_.size()) {
    least_ = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), 0};
    Seen most{-least_.u, -least_.v, 0};
    for (const Seen& s : starts_) {
      least_.u = std::min(least_.u, s.u);
      least_.v = std::min(least_.v, s.v);
      most.u = std::max(most.u, s.u);
      most.v = std::max(most.v, s.v);
    }
    side_ = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(starts_.size()))), 1, 2048);
    per_u_ = most.u > least_.u ? side_ / (most.u - least_.u) : 0;
    per_v_ = most.v > least_.v ? side_ / (most.v - least_.v) : 0;
    first_.assign(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_) + 1, 0);
    for (const Seen& s : starts_) ++first_[cell_of(s) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    sorted_.resize(starts_.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < starts_.size(); ++i) sorted_[next[cell_of(starts_[i])]++] = i;
  }

  void meet(const glm::uvec3& t, std::size_t triangle, std::span<const glm::vec3> positions) {
    const Seen a = seen(glm::dvec3(positions[t.x]));
    const Seen b = seen(glm::dvec3(positions[t.y]));
    const Seen c = seen(glm::dvec3(positions[t.z]));
    const auto [u_least, u_most] = std::minmax({a.u, b.u, c.u});
    const auto [v_least, v_most] = std::minmax({a.v, b.v, c.v});
    const double from_u = (u_least - least_.u) * per_u_;
    const double from_v = (v_least - least_.v) * per_v_;
    const double to_u = (u_most - least_.u) * per_u_;
    const double to_v = (v_most - least_.v) * per_v_;
    if (to_u < 0 || to_v < 0 || from_u > side_ || from_v > side_) return;
    const std::uint32_t component = components_.of_vertex(t.x);
    for (int v = at(from_v); v <= at(to_v); ++v) {
      for (int u = at(from_u); u <= at(to_u); ++u) {
        const std::size_t cell =
            static_cast<std::size_t>(v) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(u);
        for (std::uint32_t i = first_[cell]; i < first_[cell + 1]; ++i) {
          if (sorted_[i] != component) meet(sorted_[i], a, b, c, triangle);
        }
      }
    }
  }

  [[nodiscard]] const Hit& hit(std::size_t component) const { return hits_[component]; }

 private:
  void meet(std::uint32_t ray, const Seen& a, const Seen& b, const Seen& c, std::size_t triangle) {
    const Seen& start = starts_[ray];
    const double at_a = turn(b, c, start);
    const double at_b = turn(c, a, start);
    const double at_c = turn(a, b, start);
    const auto [least, most] = std::minmax({at_a, at_b, at_c});
    if (!(least >= 0 || most <= 0) || least == most) return;
    const double along = (at_a * a.along + at_b * b.along + at_c * c.along) / (at_a + at_b + at_c);
    if (!(along > start.along)) return;
    const tbb::spin_mutex::scoped_lock lock(locks_[ray]);
    Hit& hit = hits_[ray];
    if (along < hit.along || (along == hit.along && triangle < hit.triangle)) hit = {along, triangle};
  }

  [[nodiscard]] int at(double cell) const {
    return static_cast<int>(std::clamp(cell, 0.0, static_cast<double>(side_ - 1)));
  }
  [[nodiscard]] std::size_t cell_of(const Seen& s) const {
    return static_cast<std::size_t>(at((s.v - least_.v) * per_v_)) * static_cast<std::size_t>(side_) +
           static_cast<std::size_t>(at((s.u - least_.u) * per_u_));
  }

  const Components& components_;
  std::vector<Seen> starts_;  // one a component
  std::vector<Hit> hits_;
  std::vector<tbb::spin_mutex> locks_;
  Seen least_;
  int side_ = 1;  // cells a side of a square around all starts
  double per_u_ = 0;
  double per_v_ = 0;
  std::vector<std::uint32_t> first_;   // of each cell, in `sorted_`
  std::vector<std::uint32_t> sorted_;  // rays by their cells
};

// Of each component, the middle of the triangle at its farthest vertex that faces most along the rays; the wall of a
// cavity faces against them there.
std::vector<Seen> find_starts(const mesh::Mesh& mesh, const Components& components,
                              std::span<const mesh::ComponentFacts> facts) {
  std::vector<std::uint32_t> farthest(facts.size(), Components::kNone);
  std::vector<double> along(facts.size(), -std::numeric_limits<double>::infinity());
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const std::uint32_t component = components.of_vertex(v);
    if (component == Components::kNone) continue;
    const double at = seen(glm::dvec3(mesh.positions[v])).along;
    if (!(at > along[component])) continue;
    along[component] = at;
    farthest[component] = v;
  }
  std::vector<Seen> starts(facts.size());
  std::vector<double> most(facts.size(), -std::numeric_limits<double>::infinity());
  for (const glm::uvec3& t : mesh.triangles) {
    if (mesh::repeats_index(t)) continue;
    const std::uint32_t component = components.of_vertex(t.x);
    const std::uint32_t vertex = farthest[component];
    if (t.x != vertex && t.y != vertex && t.z != vertex) continue;
    const glm::dvec3 a(mesh.positions[t.x]);
    const glm::dvec3 b(mesh.positions[t.y]);
    const glm::dvec3 c(mesh.positions[t.z]);
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double length = glm::length(normal);
    const double faces = length > 0 ? glm::dot(normal, kAlong) / length : 0;
    const double score = facts[component].is_cavity() ? -faces : faces;
    if (!(score > most[component])) continue;
    most[component] = score;
    starts[component] = seen((a + b + c) / 3.0);
  }
  return starts;
}

}  // namespace

Nesting find_nesting(const mesh::Mesh& mesh, const Components& components,
                     std::span<const mesh::ComponentFacts> facts) {
  const std::size_t count = facts.size();
  Nesting nesting;
  nesting.body.resize(count);
  std::iota(nesting.body.begin(), nesting.body.end(), 0U);
  nesting.within.assign(count, Nesting::kNone);
  if (std::ranges::none_of(facts, &mesh::ComponentFacts::is_cavity)) return nesting;

  const std::vector<Seen> starts = find_starts(mesh, components, facts);
  Rays rays(components, starts);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.triangles.size(), 1 << 12), [&](const auto& range) {
    for (std::size_t t = range.begin(); t != range.end(); ++t) {
      if (!mesh::repeats_index(mesh.triangles[t])) rays.meet(mesh.triangles[t], t, mesh.positions.span());
    }
  });

  // What a shell lies in follows from the shell that its ray meets, which is settled first.
  enum class State : std::uint8_t { open, waiting, settled };
  std::vector<State> states(count, State::open);
  std::vector<std::uint32_t> waiting;
  for (std::uint32_t first = 0; first < count; ++first) {
    waiting.assign(1, first);
    while (!waiting.empty()) {
      const std::uint32_t component = waiting.back();
      const Hit& hit = rays.hit(component);
      const bool meets = facts[component].is_closed() && std::isfinite(hit.along);
      const std::uint32_t met = meets ? components.of_vertex(mesh.triangles[hit.triangle].x) : component;
      if (states[component] == State::open && meets && states[met] == State::open) {
        states[component] = State::waiting;
        waiting.push_back(met);
        continue;
      }
      waiting.pop_back();
      if (states[component] == State::settled) continue;
      states[component] = State::settled;
      if (!meets) continue;
      if (facts[component].is_cavity()) {
        nesting.body[component] = nesting.body[met];
      } else {
        nesting.within[component] = facts[met].is_cavity() ? met : nesting.within[met];
      }
    }
  }
  return nesting;
}

}  // namespace isoextract::edit
