// A patch of a mesh with its own vertex numbers, and the triangles around each vertex.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/hash.hpp"
#include "edit/detail/collapse_state.hpp"

namespace isoextract::edit {

// Connectivity of a patch. The derived class keeps corners_, removed_ and the corner lists up to date.
class PatchMesh {
 protected:
  using Corners = glm::uvec3;  // in the patch's vertex numbers
  struct Around {
    std::uint32_t triangle, from, next;  // the edge opposite the vertex, in the triangle's direction
  };
  struct Ring {
    std::vector<Around> around;
    std::vector<std::uint32_t> neighbors;  // without duplicates
  };

  // Takes `patch` as collapse_edges() does; `locked` vertices are fixed.
  PatchMesh(CollapseState& state, std::span<const std::uint32_t> patch, std::span<const char> locked)
      : state_(state), triangles_(patch) {
    number_vertices();
    look_around_vertices(locked);
  }

  // Lists the triangles and neighbors of v. Also unlinks the corners of removed triangles.
  void look_around(std::uint32_t v, Ring& ring) {
    ring.around.clear();
    ring.neighbors.clear();
    std::uint32_t* link = &first_corner_[v];
    while (*link != kNone) {
      const std::uint32_t corner = *link;
      const std::uint32_t t = corner / 3;
      if (removed_[t] != 0) {
        *link = next_corner_[corner];
        continue;
      }
      const auto at = static_cast<int>(corner % 3);
      ring.around.push_back({t, corners_[t][(at + 1) % 3], corners_[t][(at + 2) % 3]});
      link = &next_corner_[corner];
    }
    for (const Around& a : ring.around) ring.neighbors.push_back(a.from);
    if (on_boundary_[v] != 0) {  // the ring is open: its last vertex starts no edge
      for (const Around& a : ring.around) {
        if (std::none_of(ring.around.begin(), ring.around.end(), [&](const Around& b) { return b.from == a.next; })) {
          ring.neighbors.push_back(a.next);
        }
      }
    }
  }

  // Returns whether an existing edge has one triangle.
  [[nodiscard]] bool is_boundary_edge(std::uint32_t a, std::uint32_t b) const {
    std::size_t triangles = 0;
    for (std::uint32_t c = first_corner_[a]; c != kNone; c = next_corner_[c]) {
      const Corners& t = corners_[c / 3];
      if (removed_[c / 3] == 0 && (t.x == b || t.y == b || t.z == b)) ++triangles;
    }
    return triangles == 1;
  }

  [[nodiscard]] glm::dvec3 cross_product(const Corners& t) const {
    return glm::cross(places_[t.y] - places_[t.x], places_[t.z] - places_[t.x]);
  }

  [[nodiscard]] bool joined(std::uint32_t a, std::uint32_t b) const {
    for (std::uint32_t c = first_corner_[a]; c != kNone; c = next_corner_[c]) {
      const Corners& t = corners_[c / 3];
      if (removed_[c / 3] == 0 && (t.x == b || t.y == b || t.z == b)) return true;
    }
    return false;
  }

  // Tests the stored positions, in double.
  [[nodiscard]] bool has_area(const Corners& t) const {
    const glm::dvec3 a(state_.stored[vertices_[t.x]]);
    const glm::dvec3 ab = glm::dvec3(state_.stored[vertices_[t.y]]) - a;
    const glm::dvec3 ac = glm::dvec3(state_.stored[vertices_[t.z]]) - a;
    return glm::cross(ab, ac) != glm::dvec3(0);
  }

  // Returns height divided by longest side.
  [[nodiscard]] double thickness(const Corners& t) const {
    double longest = 0;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 edge = places_[t[(corner + 1) % 3]] - places_[t[corner]];
      longest = std::max(longest, glm::dot(edge, edge));
    }
    return longest > 0 ? glm::length(cross_product(t)) / longest : 0;
  }

  CollapseState& state_;
  std::span<const std::uint32_t> triangles_;  // triangle numbers in the mesh
  std::vector<std::uint32_t> vertices_;       // vertex numbers in the mesh
  glm::dvec3 origin_{0.0};
  std::vector<glm::dvec3> places_;
  std::vector<Corners> corners_;
  std::vector<char> removed_;                // 1: triangle removed
  std::vector<std::uint32_t> first_corner_;  // for each vertex: 3 * triangle + corner
  std::vector<std::uint32_t> next_corner_;
  std::vector<char> fixed_;        // 1: vertex must stay
  std::vector<char> on_boundary_;  // 1: vertex has a single open fan

 private:
  // Numbers vertices by first use. Positions become relative to one vertex, so that products keep their precision.
  void number_vertices() {
    std::size_t size = 16;
    while (size < triangles_.size() * 4) size *= 2;  // up to three vertices a triangle
    std::vector<std::pair<std::uint32_t, std::uint32_t>> table(size, {kNone, kNone});
    const auto number = [&](std::uint32_t vertex) {
      std::size_t slot = hash_coordinates(vertex, 0, 0) & (size - 1);
      while (table[slot].first != vertex && table[slot].first != kNone) slot = (slot + 1) & (size - 1);
      if (table[slot].first == kNone) {
        table[slot] = {vertex, static_cast<std::uint32_t>(vertices_.size())};
        vertices_.push_back(vertex);
      }
      return table[slot].second;
    };
    corners_.reserve(triangles_.size());
    vertices_.reserve(triangles_.size());
    for (const std::uint32_t t : triangles_) {
      const glm::uvec3& c = state_.corners[t];
      const std::uint32_t a = number(c.x);
      const std::uint32_t b = number(c.y);
      corners_.emplace_back(a, b, number(c.z));
    }
    origin_ = state_.positions[vertices_[vertices_.size() / 2]];
    places_.reserve(vertices_.size());
    for (const std::uint32_t vertex : vertices_) places_.push_back(glm::dvec3(state_.positions[vertex]) - origin_);
    removed_.assign(triangles_.size(), 0);
    // Linked lists of the corners at each vertex.
    first_corner_.assign(vertices_.size(), kNone);
    next_corner_.assign(3 * triangles_.size(), kNone);
    for (std::uint32_t corner = static_cast<std::uint32_t>(next_corner_.size()); corner-- > 0;) {
      std::uint32_t& first = first_corner_[corners_[corner / 3][static_cast<int>(corner % 3)]];
      next_corner_[corner] = first;
      first = corner;
    }
  }

  // Fixes locked vertices, and vertices whose triangles form neither one closed fan nor one open fan.
  void look_around_vertices(std::span<const char> locked) {
    fixed_.assign(vertices_.size(), 0);
    on_boundary_.assign(vertices_.size(), 0);
    Ring ring;
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      look_around(v, ring);
      const std::vector<Around>& around = ring.around;
      std::size_t starts = 0;
      std::size_t start = 0;
      bool twice = false;
      for (std::size_t i = 0; i < around.size(); ++i) {
        std::size_t before = 0;
        for (std::size_t j = 0; j < around.size(); ++j) {
          before += around[j].next == around[i].from ? 1 : 0;
          if (i != j && (around[i].from == around[j].from || around[i].next == around[j].next)) twice = true;
        }
        if (before == 0) {
          ++starts;
          start = i;
        }
      }
      std::size_t walked = 1;
      for (std::size_t i = start; !twice && walked < around.size(); ++walked) {
        const auto next =
            std::find_if(around.begin(), around.end(), [&](const Around& a) { return a.from == around[i].next; });
        if (next == around.end() || (starts == 0 && next == around.begin())) break;
        i = static_cast<std::size_t>(next - around.begin());
      }
      const bool one_fan = !twice && starts <= 1 && walked == around.size();
      on_boundary_[v] = one_fan && starts == 1 ? 1 : 0;
      fixed_[v] = !one_fan || locked[vertices_[v]] != 0 ? 1 : 0;
    }
  }
};

}  // namespace isoextract::edit
