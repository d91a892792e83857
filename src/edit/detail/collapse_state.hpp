// A mesh while its edges are collapsed: triangles keep their numbers, so that what happened to each can be looked up,
// and taken back.
//
// A collapse moves one vertex into a neighbour: the two triangles (one at an open border) between them go, the others
// around the vertex turn to the neighbour. What it did is undone by itself once all later collapses are undone that
// changed one of its triangles. The order of these is that of a multi-triangulation (De Floriani, Magillo, Puppo:
// Efficient implementation of multi-triangulations. IEEE Visualization 1998): any set of collapses that has all earlier
// ones on which it depends makes a mesh, with the components and the Euler number of the first. For a collapse makes
// and removes edges of its own vertex and the one that it goes to alone; edges between others stay what they are, and
// so does the link condition of those that are left.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/triangle_tree.hpp"

namespace isoextract::edit {

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// What is known of the greatest distance of a triangle's points to the other surface.
struct KnownDistance {
  double lower = 0;
  double upper = -1;  // below 0: nothing is known

  [[nodiscard]] bool is_known() const { return upper >= 0; }
};

struct CollapseState {
  // At least one triangle. `positions` are in the space in which distances are meant, `stored` those of the mesh.
  CollapseState(std::span<const glm::vec3> positions, std::span<const glm::vec3> stored,
                std::span<const glm::uvec3> original);

  std::span<const glm::vec3> positions;
  std::span<const glm::vec3> stored;
  std::span<const glm::uvec3> original;
  std::vector<glm::uvec3> corners;
  std::vector<char> gone;
  std::vector<std::uint32_t> changed_by;  // the last collapse that changed the triangle, or kNone
  // Vertices that went and are held against the triangle that they are nearest to: lists that end with kNone.
  std::vector<std::uint32_t> first_sample;
  std::vector<std::uint32_t> next_sample;
  std::vector<KnownDistance> known;  // of triangles that changed, to the original mesh
  mesh::TriangleTree original_tree;
  std::vector<std::uint32_t> original_slot;  // of each triangle, in the tree

  [[nodiscard]] bool is_original(std::uint32_t t) const { return gone[t] == 0 && changed_by[t] == kNone; }
  // What one takes for each triangle and vertex, beside the tree.
  static constexpr std::uint64_t kTriangleBytes =
      sizeof(glm::uvec3) + 1 + 3 * sizeof(std::uint32_t) + sizeof(KnownDistance);
  static constexpr std::uint64_t kVertexBytes = sizeof(std::uint32_t);
};

struct Collapse {
  std::uint32_t vertex;
  std::uint32_t to;
  std::uint32_t first_record;
  std::uint32_t records;
};

// What one patch went through. Its collapses are numbered from `first`.
struct CollapseLog {
  struct Record {
    std::uint32_t triangle;
    std::uint32_t changed_before;  // `changed_by` until then
  };
  std::uint32_t first = 0;
  std::uint32_t removed = 0;    // triangles
  double farthest_squared = 0;  // of points of the new triangles from the original mesh, and of those that went
  std::vector<Collapse> collapses;
  std::vector<Record> records;
};

// A triangle that an undone collapse changed, with the corners that it had until then.
struct PutBack {
  std::uint32_t triangle;
  glm::uvec3 corners;
};

// The vertex that a collapse moved. `logs` rise by `first`.
[[nodiscard]] std::uint32_t collapsed_vertex(std::uint32_t collapse, std::span<const CollapseLog> logs);

// After collapses were undone: vertices that are there again are held against triangles no more. Before the next
// collapse, which would hold them twice.
void drop_samples_that_are_back(CollapseState& state);

// Undoes a collapse and all that depend on it, the latest first. `logs` rise by `first`. Triangles that were there and
// change, or come back, are added to `changed`, perhaps several times. Samples are not put back. Returns how many
// collapses were undone.
std::size_t undo_collapse(std::uint32_t collapse, CollapseState& state, std::span<const CollapseLog> logs,
                          std::vector<PutBack>& changed);

}  // namespace isoextract::edit
