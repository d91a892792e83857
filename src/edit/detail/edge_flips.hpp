// Flips edges of intersecting triangles, where that leaves fewer intersecting pairs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "edit/detail/pair_counter.hpp"
#include "edit/detail/smooth_signal.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// Changes the surface only within the two triangles of an edge.
class EdgeFlips {
 public:
  // Keeps references to mesh and signal. The caller reserves bytes(). Throws std::bad_alloc.
  EdgeFlips(mesh::Mesh& mesh, const Signal& signal);

  [[nodiscard]] static std::uint64_t bytes(const mesh::Mesh& mesh) {
    return mesh::Adjacency::bytes(mesh.triangles.size(), mesh.positions.size()) + PairCounter::bytes(mesh) +
           mesh.positions.size();
  }

  // Flips at most one edge at each vertex, and returns the number of flips. Ends early if the context is cancelled. For
  // more flips, make a new object.
  std::size_t run(std::span<const std::array<std::uint32_t, 2>> pairs, const Context& context);

 private:
  struct Flip {
    std::array<PairCounter::Triangle, 2> after;
    std::size_t gain;  // of pairs
  };

  [[nodiscard]] bool are_joined(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] std::optional<Flip> flip_at(std::uint32_t t, int corner) const;
  void apply(const Flip& flip);

  mesh::Mesh& mesh_;
  const Signal& signal_;
  mesh::Adjacency around_;  // of the triangles before the flips
  PairCounter counter_;
  std::vector<char> changed_;  // 1: around_ is outdated at this vertex
};

}  // namespace isoextract::edit
