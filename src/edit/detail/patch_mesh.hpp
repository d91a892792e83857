// A patch of a mesh with its own vertex numbers, and the triangles around each vertex.
//
// Sheets may meet in curves: edges that are not between two triangles of one sheet. A boundary is a curve of one sheet.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
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

  // Takes `patch` as collapse_edges() does; `locked` vertices and those with VertexRole::kept are fixed.
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
      // An index into the vector itself would be a branch for each corner.
      const auto corners = std::bit_cast<std::array<std::uint32_t, 3>>(corners_[t]);
      const std::uint32_t at = corner % 3;
      ring.around.push_back({t, corners[(at + 1) % 3], corners[(at + 2) % 3]});
      link = &next_corner_[corner];
    }
    if (leaves_[v] == 0) {
      ring.neighbors.resize(ring.around.size());
      std::ranges::transform(ring.around, ring.neighbors.begin(), &Around::from);
      return;
    }
    const auto add = [&](std::uint32_t w) {
      if (std::ranges::find(ring.neighbors, w) == ring.neighbors.end()) ring.neighbors.push_back(w);
    };
    for (const Around& a : ring.around) add(a.from);
    for (const Around& a : ring.around) add(a.next);
  }

  // Lists the vertices opposite the edges from the ring's vertex to w.
  static void list_apexes(const Ring& ring, std::uint32_t w, std::vector<std::uint32_t>& apexes) {
    apexes.clear();
    for (const Around& a : ring.around) {
      if (a.from == w) apexes.push_back(a.next);
      if (a.next == w) apexes.push_back(a.from);
    }
  }

  // Lists the sheets of the ring's triangles.
  void list_sheets(const Ring& ring, std::vector<std::uint32_t>& sheets) const {
    sheets.clear();
    for (const Around& a : ring.around) {
      const std::uint32_t s = sheet(a.triangle);
      if (std::ranges::find(sheets, s) == sheets.end()) sheets.push_back(s);
    }
  }

  // Returns whether the edge from the ring's vertex to w is part of a curve: not between two triangles of one sheet
  // that run along it in opposite directions.
  [[nodiscard]] bool is_curve_edge(const Ring& ring, std::uint32_t w) const {
    const Around* from = nullptr;
    const Around* next = nullptr;
    for (const Around& a : ring.around) {
      if (a.from == w && std::exchange(from, &a) != nullptr) return true;
      if (a.next == w && std::exchange(next, &a) != nullptr) return true;
    }
    return from == nullptr || next == nullptr || sheet(from->triangle) != sheet(next->triangle);
  }

  // Returns whether v is an inner vertex of a curve along which a label touches itself. A locked vertex may be the end
  // of several curves.
  [[nodiscard]] bool is_touching(std::uint32_t v) const {
    return leaves_[v] > 0 && locked_[v] == 0 && state_.has_role(vertices_[v], VertexRole::touching);
  }

  [[nodiscard]] std::uint32_t sheet(std::uint32_t triangle) const { return state_.sheet(triangles_[triangle]); }

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

  // Returns whether corners are on both sides (CollapseStart::sides).
  [[nodiscard]] bool joins_sides(const Corners& t) const {
    if (state_.sides.empty()) return false;
    const auto [least, most] =
        std::minmax({state_.sides[vertices_[t.x]], state_.sides[vertices_[t.y]], state_.sides[vertices_[t.z]]});
    return least < 0 && most > 0;
  }

  // The cross product of a triangle's edges, and its height divided by its longest side.
  struct Shape {
    glm::dvec3 cross;
    double thickness;
  };
  [[nodiscard]] Shape shape(const Corners& t) const {
    double longest = 0;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 edge = places_[t[(corner + 1) % 3]] - places_[t[corner]];
      longest = std::max(longest, glm::dot(edge, edge));
    }
    const glm::dvec3 cross = cross_product(t);
    return {cross, longest > 0 ? glm::length(cross) / longest : 0};
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
  std::vector<char> locked_;          // 1: the caller locked the vertex, as one with triangles outside the patch
  std::vector<char> fixed_;           // 1: vertex must stay
  std::vector<std::uint8_t> leaves_;  // of a vertex on a curve: count_leaves(); else 0

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

  // Fixes locked vertices, and vertices that lie neither within a sheet nor on a curve.
  void look_around_vertices(std::span<const char> locked) {
    locked_.assign(vertices_.size(), 0);
    fixed_.assign(vertices_.size(), 0);
    leaves_.assign(vertices_.size(), 1);
    Ring ring;
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      look_around(v, ring);
      locked_[v] = locked[vertices_[v]] != 0 ? 1 : 0;
      const std::optional<std::uint8_t> leaves = count_leaves(ring);
      leaves_[v] = leaves.value_or(0);
      fixed_[v] = !leaves || locked_[v] != 0 || state_.has_role(vertices_[v], VertexRole::kept) ? 1 : 0;
    }
  }

  // Returns whether the triangles around a vertex form one closed fan within a sheet: a cycle through all of them.
  [[nodiscard]] bool is_closed_fan(const std::vector<Around>& around) const {
    std::size_t at = 0;
    for (std::size_t walked = 1; sheet(around[at].triangle) == sheet(around[0].triangle); ++walked) {
      const std::uint32_t w = around[at].next;
      if (w == around[0].from) return walked == around.size();
      if (walked == around.size()) return false;
      at = static_cast<std::size_t>(std::ranges::find(around, w, &Around::from) - around.begin());
      if (at == around.size()) return false;
    }
    return false;
  }

  // Returns 0 if the triangles around a vertex form one closed fan within a sheet. Returns the number of fans if they
  // are leaves along a curve: each within a sheet, and from one to the other of the same two curve edges. A boundary is
  // a curve with one leaf. Returns null for any other vertex.
  [[nodiscard]] std::optional<std::uint8_t> count_leaves(const Ring& ring) const {
    const std::vector<Around>& around = ring.around;
    if (around.empty()) return std::nullopt;
    if (is_closed_fan(around)) return std::uint8_t{0};
    std::vector<std::uint32_t> ends;  // of curve edges
    for (const std::uint32_t w : ring.neighbors) {
      if (is_curve_edge(ring, w)) ends.push_back(w);
    }
    if (ends.size() != 2) return std::nullopt;
    const auto is_end = [&](std::uint32_t w) { return w == ends[0] || w == ends[1]; };
    // Follows each fan from its first triangle.
    std::size_t walked = 0;
    std::size_t fans = 0;
    constexpr std::size_t kMost = 255;
    for (std::size_t start = 0; start < around.size() && fans < kMost; ++start) {
      if (!is_end(around[start].from)) continue;
      ++fans;
      std::size_t at = start;
      for (;; ++walked) {
        if (walked >= around.size()) return std::nullopt;
        const std::uint32_t w = around[at].next;
        if (is_end(w)) break;
        at = static_cast<std::size_t>(std::ranges::find(around, w, &Around::from) - around.begin());
      }
      ++walked;
      if (around[start].from == around[at].next) return std::nullopt;  // a cone from a curve edge to itself
    }
    if (walked != around.size()) return std::nullopt;
    return static_cast<std::uint8_t>(fans);
  }
};

}  // namespace isoextract::edit
