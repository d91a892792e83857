// The edges and fans at the vertices of a mesh, counted one vertex at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/adjacency.hpp"
#include "mesh/topology.hpp"

namespace isoextract::mesh {

// Adds the counts of edges and vertices that TopologyPart makes to those of `all`.
inline void add_counts(const Topology& part, Topology& all) {
  all.edges += part.edges;
  all.open_edges += part.open_edges;
  all.nonmanifold_edges += part.nonmanifold_edges;
  all.misoriented_edges += part.misoriented_edges;
  all.nonmanifold_vertices += part.nonmanifold_vertices;
  all.unused_vertices += part.unused_vertices;
}

// The facts that one thread finds, vertex by vertex, for each part of a mesh (a component). An edge counts at the lower
// of its ends. The caller sets `euler`, `components` and `repeated_index_triangles`.
class TopologyPart {
 public:
  explicit TopologyPart(std::size_t parts) : facts_(parts) {}

  // Examines a vertex that belongs to a part, with all its corners in ascending order.
  void look_at(std::uint32_t vertex, std::size_t part, std::span<const Corner> corners,
               std::span<const glm::uvec3> triangles) {
    Topology& facts = facts_[part];
    sound_.clear();
    ways_.clear();
    for (const Corner corner : corners) {
      const glm::uvec3& t = triangles[triangle_of(corner)];
      if (has_repeated_index(t)) continue;
      const auto c = static_cast<int>(corner % 3);
      sound_.push_back(corner);
      ways_.push_back({t[(c + 1) % 3], t[(c + 2) % 3]});
    }
    if (sound_.empty()) {
      ++facts.unused_vertices;
    } else if (forms_closed_fan()) {
      for (const Way& way : ways_) facts.edges += way.to > vertex ? 1 : 0;
    } else {
      look_at_edges(vertex, triangles, facts);
    }
  }

  // Adds the facts of each part to those of `all`, which has as many parts.
  void add_to(std::vector<Topology>& all) const {
    for (std::size_t i = 0; i < facts_.size(); ++i) add_counts(facts_[i], all[i]);
  }

 private:
  // A triangle's path around the vertex: the edges by which it leaves and returns.
  struct Way {
    std::uint32_t to;
    std::uint32_t from;
  };

  // Returns whether the triangles form one closed fan: each triangle leaves along the edge by which the one before it
  // returned, until all have been met. Every edge then has two triangles, which run along it in opposite directions.
  // Almost every vertex is like this, and this test takes few comparisons.
  [[nodiscard]] bool forms_closed_fan() const {
    constexpr std::size_t kMany = 32;  // with more triangles sorting is faster
    if (ways_.size() > kMany) return false;
    std::size_t at = 0;
    for (std::size_t met = 1;; ++met) {
      std::size_t next = 0;
      while (next < ways_.size() && ways_[next].to != ways_[at].from) ++next;
      if (next == ways_.size() || met > ways_.size()) return false;
      if (next == 0) return met == ways_.size();
      at = next;
    }
  }

  void look_at_edges(std::uint32_t vertex, std::span<const glm::uvec3> triangles, Topology& facts) {
    star_.look_at(sound_, triangles);
    if (star_.fans() > 1) ++facts.nonmanifold_vertices;
    const auto sides = star_.sides();
    for (std::size_t first = 0; first < sides.size();) {
      std::size_t last = first;
      while (last < sides.size() && sides[last].end == sides[first].end) ++last;
      if (sides[first].end > vertex) add_edge(sides.subspan(first, last - first), facts);
      first = last;
    }
  }

  static void add_edge(std::span<const VertexStar::Side> sides, Topology& facts) {
    ++facts.edges;
    if (sides.size() == 1) ++facts.open_edges;
    if (sides.size() > 2) ++facts.nonmanifold_edges;
    if (sides.size() == 2 && sides[0].outgoing == sides[1].outgoing) ++facts.misoriented_edges;
  }

  std::vector<Topology> facts_;
  VertexStar star_;
  std::vector<Corner> sound_;
  std::vector<Way> ways_;  // one per corner in `sound_`
};

}  // namespace isoextract::mesh
