// A mesh while its edges are collapsed. Triangles keep their numbers, so that each collapse can be looked up and
// undone.
//
// A collapse moves one vertex onto a neighbor. It removes the two triangles that have both vertices (one at a boundary
// edge, one per sheet along a curve); the other triangles of the vertex get the neighbor as their corner. A collapse
// can be undone once all later collapses that changed one of its triangles are undone. This order is that of a
// multi-triangulation (De Floriani, Magillo, Puppo: Efficient implementation of multi-triangulations. IEEE
// Visualization 1998). Any set of collapses that includes all collapses it depends on gives a mesh with the components
// and the Euler number of the original. The reason: a collapse adds and removes only edges at its two vertices, so the
// link condition of the other collapses still holds.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "edit/detail/sheet_trees.hpp"
#include "edit/detail/surface_cover.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::edit {

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// Bounds of the largest distance from a triangle's points to the other surface.
struct DistanceBounds {
  double lower = 0;
  double upper = -1;  // below 0: not known

  [[nodiscard]] bool is_known() const { return upper >= 0; }
};

// A mesh of which edges are collapsed already: a part of a larger one, with one sheet and at least one triangle that is
// not gone. Does not own its data. Collapses of the past cannot be undone.
struct CollapseStart {
  // For each triangle: its corners now, 1 if it is removed or outside the part, and 1 if its original is outside.
  std::span<const glm::uvec3> corners;
  std::span<const char> gone;
  std::span<const char> not_original;
  // For each vertex: 1 if it must not move, 1 if it is tried first (CollapseVertices), and its side: no new triangle
  // has corners of side -1 and of side 1. A vertex that is not locked has all its triangles in the part.
  std::span<const char> locked;
  std::span<const char> wanted;
  std::span<const std::int8_t> sides;
  std::size_t least_triangles = 0;  // the part keeps this many triangles or a few less, or more
  double slack = 0;                 // rounding error of distances, at least; the same for all parts of a mesh
};

struct CollapseState {
  // Needs at least one original triangle. `positions` are in the space of distances, `stored` are those of the mesh.
  // All spans must outlive the state. Without `start`, the mesh is the original.
  CollapseState(std::span<const glm::vec3> positions, std::span<const glm::vec3> stored,
                std::span<const glm::uvec3> original, const Sheets& sheets = {}, const CollapseStart* start = nullptr);
  std::span<const glm::vec3> positions;
  std::span<const glm::vec3> stored;
  std::span<const glm::uvec3> original;
  std::vector<glm::uvec3> corners;
  std::vector<char> gone;
  std::vector<std::uint32_t> changed_by;  // the last collapse that changed the triangle, or kNone
  // The samples of each triangle: removed vertices that have this triangle as their nearest. Linked lists hold them and
  // end with kNone.
  std::vector<std::uint32_t> first_sample;
  std::vector<std::uint32_t> next_sample;
  // The number of the first collapse since undo_intersections() looked at all pairs. For each triangle, the patch of
  // the first round since then that had it, as the number of the patch's first collapse; kNone: no patch had it.
  std::uint32_t first_unchecked = 0;
  std::vector<std::uint32_t> first_patch;
  std::vector<char> tangled;          // 1: an allowed collapse left the triangle in an intersecting pair
  std::vector<DistanceBounds> known;  // distance of each changed triangle to the original mesh
  Sheets sheets;
  std::span<const glm::uvec3> start;    // the corners of each triangle before any collapse of this state
  std::span<const char> gone_at_start;  // empty: none
  std::span<const char> not_original;   // 1: the triangle's original is not part of the state; empty: none
  std::span<const std::int8_t> sides;   // of vertices, as in CollapseStart; empty: all 0
  SheetTrees original_trees;
  std::vector<std::uint32_t> original_slot;  // the slot of each triangle in the tree of its sheet
  SurfaceCover original_cover;

  [[nodiscard]] std::uint32_t sheet(std::uint32_t t) const { return sheets.of(t); }
  [[nodiscard]] bool has_role(std::uint32_t v, VertexRole role) const {
    return !sheets.roles.empty() && sheets.roles[v] == role;
  }
  [[nodiscard]] const mesh::TriangleTree& original_tree(std::uint32_t t) const { return original_trees.tree(sheet(t)); }
  // Returns whether the state began with collapsed edges.
  [[nodiscard]] bool has_past() const { return !gone_at_start.empty(); }
  [[nodiscard]] bool has_original(std::uint32_t t) const { return not_original.empty() || not_original[t] == 0; }
  // Returns whether a collapse changed the triangle since undo_intersections() looked at all pairs.
  [[nodiscard]] bool is_unchecked(std::uint32_t t) const {
    return changed_by[t] != kNone && changed_by[t] >= first_unchecked;
  }
  [[nodiscard]] bool is_original(std::uint32_t t) const { return gone[t] == 0 && corners[t] == original[t]; }
  [[nodiscard]] std::size_t count_remaining() const;
  // Bytes for each triangle and each vertex, without the tree.
  static constexpr std::uint64_t kTriangleBytes =
      sizeof(glm::uvec3) + 2 + 4 * sizeof(std::uint32_t) + sizeof(DistanceBounds) + SurfaceCover::kTriangleBytes;
  static constexpr std::uint64_t kVertexBytes = sizeof(std::uint32_t);
  static constexpr std::size_t kMostSamples = 6;  // of a triangle: the farthest

 private:
  void attach_removed_vertices();
};

struct Collapse {
  std::uint32_t vertex;
  std::uint32_t to;
  std::uint32_t first_record;
  std::uint32_t records;
};

// The collapses of one patch, numbered from `first`.
struct CollapseLog {
  struct Record {
    std::uint32_t triangle;
    std::uint32_t changed_before;  // `changed_by` before this collapse
  };
  std::uint32_t first = 0;
  std::uint32_t removed = 0;  // triangles
  std::uint64_t refused = 0;  // collapses that would have made triangles intersect
  // Largest squared distance to the other surface, of removed vertices and of points of new triangles.
  double farthest_squared = 0;
  std::vector<Collapse> collapses;
  std::vector<Record> records;
};

// A triangle that an undone collapse had changed, with its corners before the undo.
struct RestoredTriangle {
  std::uint32_t triangle;
  glm::uvec3 corners;
};

// Returns the log that holds a collapse. `logs` are sorted by `first`.
[[nodiscard]] const CollapseLog& find_log(std::uint32_t collapse, std::span<const CollapseLog> logs);

// Returns the collapse with a number. `logs` are sorted by `first`.
[[nodiscard]] const Collapse& find_collapse(std::uint32_t collapse, std::span<const CollapseLog> logs);

// Removes from the sample lists all vertices that undone collapses brought back. Call it after undoing and before the
// next collapse, which would list them twice.
void drop_restored_samples(CollapseState& state);

// Undoes a collapse and all that depend on it, the latest first. `logs` are sorted by `first`. Adds every triangle that
// changes or comes back to `changed`, possibly more than once. Leaves the sample lists as they are. Returns the number
// of undone collapses.
std::size_t undo_collapse(std::uint32_t collapse, CollapseState& state, std::span<const CollapseLog> logs,
                          std::vector<RestoredTriangle>& changed);

}  // namespace isoextract::edit
