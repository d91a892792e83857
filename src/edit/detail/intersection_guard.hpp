// Finds whether a collapse in a patch would make triangles intersect, as mesh/self_intersections.hpp counts it.
//
// Knows the triangles of the patch only. A BoxTree finds the triangles near new ones. A collapse does not change the
// shape of the tree; the boxes of its nodes grow where new triangles are larger. The pairs found are tested exactly.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "edit/detail/collapse_state.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/triangle_overlap.hpp"

namespace isoextract::edit {

class IntersectionGuard {
 public:
  using Corners = std::array<glm::vec3, 3>;

 private:
  // A triangle of the patch, in the stored positions.
  struct Placed {
    Corners corners;
    std::uint32_t triangle;    // its position in the patch
    std::uint32_t looked = 0;  // number of the last allows() that had it in `around`
    bool counts = true;        // false: removed, or without area
  };

 public:
  // A triangle of the patch, by its position in the patch, with its corners after a collapse.
  struct Changed {
    std::uint32_t triangle;
    Corners corners;
  };

  // Bytes for each triangle of the patch: in `placed_`, `slots_` and the tree with its boxes.
  static constexpr std::uint64_t kTriangleBytes =
      sizeof(Placed) + 2 * sizeof(std::uint32_t) + sizeof(mesh::BoxTree::Item) + sizeof(mesh::FloatBox);

  // `patch` are existing triangles of the state, at least one. Keeps references to both.
  IntersectionGuard(CollapseState& state, std::span<const std::uint32_t> patch);

  // Returns whether a collapse that changes or removes the triangles `around` its vertex, and leaves `changed` of them,
  // makes no triangles intersect. Triangles that intersected before may go on to do so: the collapse must not give a
  // triangle a new partner, nor make more pairs. Marks the triangles of such pairs in CollapseState::tangled.
  [[nodiscard]] bool allows(std::span<const std::uint32_t> around, std::span<const Changed> changed);

  // Call it for each collapse, with the spans given to allows().
  void replace(std::span<const std::uint32_t> around, std::span<const Changed> changed);

 private:
  // A triangle near the changed ones.
  struct Near {
    std::uint32_t triangle;
    mesh::FloatBox box;
    mesh::CornerLanes corners;
  };

  [[nodiscard]] static Corners corners_of(const CollapseState& state, std::uint32_t triangle);
  [[nodiscard]] static mesh::BoxTree tree_of(const CollapseState& state, std::span<const std::uint32_t> patch);
  [[nodiscard]] Placed& at(std::uint32_t t) { return placed_[slots_[t]]; }
  [[nodiscard]] const Placed& at(std::uint32_t t) const { return placed_[slots_[t]]; }
  [[nodiscard]] static mesh::FloatBox box_of(const Corners& c) { return mesh::box_around(c[0], c[1], c[2]); }
  [[nodiscard]] static mesh::PlacedTriangle placed(const Corners& c);
  [[nodiscard]] static bool meet(const Corners& a, const Corners& b);
  void find_near(std::span<const std::uint32_t> around, std::span<const Changed> changed);
  [[nodiscard]] bool may_have_met(std::uint32_t t) const;
  [[nodiscard]] bool met_before(std::span<const std::uint32_t> around) const;

  CollapseState& state_;
  std::span<const std::uint32_t> patch_;
  mesh::BoxTree tree_;                // over the positions in the patch
  std::vector<std::uint32_t> slots_;  // the tree's slot of each triangle
  std::vector<Placed> placed_;        // by slot, so that triangles of a leaf are neighbors in memory
  std::uint32_t look_ = 0;
  std::vector<Near> near_;
  std::vector<std::array<std::uint32_t, 2>> met_;  // pairs: number in `changed`, triangle of the patch
};

}  // namespace isoextract::edit
