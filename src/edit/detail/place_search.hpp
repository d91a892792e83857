// Moves single vertices to places where fewer triangles intersect, and splits edges for new vertices at such places.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "edit/detail/pair_counter.hpp"
#include "edit/detail/smooth_signal.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

struct SearchLimits {
  glm::dmat3 to_metric{1.0};  // maps the mesh's coordinates to the space in which moves are measured
  double most_move = 1;
};

// Tries places in many directions at growing distances.
class PlaceSearch {
 public:
  using Pairs = std::span<const std::array<std::uint32_t, 2>>;

  // `before` are the positions from which moves are measured. Keeps references to all but `limits`. The caller reserves
  // bytes(). Throws std::bad_alloc.
  PlaceSearch(mesh::Mesh& mesh, const Signal& signal, std::span<const glm::vec3> before, const SearchLimits& limits);

  [[nodiscard]] static std::uint64_t bytes(const mesh::Mesh& mesh) {
    return mesh::Adjacency::bytes(mesh.triangles.size(), mesh.positions.size()) + PairCounter::bytes(mesh) +
           mesh.positions.size();
  }

  // Moves at most one vertex of each pair: the one whose move leaves the fewest pairs. Each move leaves fewer pairs.
  // Returns the number of moves. Ends early if the context is cancelled, as split_edges() does.
  std::size_t move_vertices(Pairs pairs, const Context& context);

  // Splits at most one edge of each pair, for a new vertex at the place that leaves the fewest pairs. Each split leaves
  // fewer pairs. The mesh must have a spare for each pair: vertices from `first_spare` on, used only by triangles with
  // repeated indices. Spare number i has the triangles first_half + 2 i and first_half + 2 i + 1, which become the new
  // halves of a split. Returns the split edges, one for each spare used. For more splits, make a new object.
  std::vector<std::array<std::uint32_t, 2>> split_edges(Pairs pairs, std::uint32_t first_spare,
                                                        std::uint32_t first_half, const Context& context);

 private:
  struct Found {
    glm::vec3 place;
    std::size_t pairs;
  };
  struct Move {
    std::uint32_t vertex;
    glm::vec3 place;
    std::size_t gain;  // of pairs
  };
  struct Split {
    std::array<std::uint32_t, 2> edge;
    std::array<PairCounter::Triangle, 4> after;  // two old triangles, and their new halves
    glm::vec3 place;
    std::size_t gain;
  };

  [[nodiscard]] std::optional<Found> find_place(std::uint32_t vertex, std::uint8_t bound, const glm::vec3& origin,
                                                std::span<const PairCounter::Triangle> star, std::size_t fewest);
  [[nodiscard]] std::optional<Move> best_move(std::uint32_t vertex);
  [[nodiscard]] std::optional<Split> split_at(std::uint32_t t, int corner, std::uint32_t spare, std::uint32_t half);
  [[nodiscard]] std::vector<PairCounter::Triangle> star_of(std::uint32_t vertex) const;

  mesh::Mesh& mesh_;
  const Signal& signal_;
  std::span<const glm::vec3> before_;
  SearchLimits limits_;
  glm::dmat3 from_metric_;
  mesh::Adjacency around_;
  PairCounter counter_;
  std::vector<char> changed_;  // 1: around_ is outdated at this vertex
};

}  // namespace isoextract::edit
