// The components of a mesh that comes in parts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/ranks.hpp"
#include "mesh/components.hpp"
#include "mesh/detail/part_vertices.hpp"

namespace isoextract::mesh {

// Joins the components of the parts that have common vertices.
class LinkedParts {
 public:
  // `far` are MeshShape::far_vertices; they must outlive the object. `what` is for messages.
  LinkedParts(std::span<const std::uint32_t> far, std::string what, const Context& context)
      : far_(far), what_(std::move(what)), context_(context), far_sets_(far.size(), Components::kNone) {}

  // Adds the next part that has triangles, in the order of the parts; `own` are its components. Fails with
  // ErrorCode::out_of_memory. Throws std::bad_alloc.
  [[nodiscard]] Result<void> add(const PartVertices& vertices, std::uint64_t first_vertex, const Components& own);
  // Numbers the components in the order of their first vertices. Call once, after the last part. If `ranks` share the
  // mesh, all of them call it; the far vertices of each are those that parts of the rank before may use, too. It then
  // fails with ErrorCode::out_of_memory, and as Ranks::gather() does. `ranks` may be null.
  [[nodiscard]] Result<void> number(Ranks* ranks);

  // Call these after number().
  //
  // Returns how many components the mesh has.
  [[nodiscard]] std::uint32_t count() const { return count_; }
  // Returns the component of the mesh for each component of the part of the `index`-th add(); empty if there is none.
  [[nodiscard]] std::span<const std::uint32_t> of_part(std::size_t index) const {
    if (index >= ends_.size()) return {};
    const std::size_t first = index == 0 ? 0 : ends_[index - 1];
    return std::span(sets_).subspan(first, ends_[index] - first);
  }
  // Returns the component of the far vertex with this index; Components::kNone if it has no triangle.
  [[nodiscard]] std::uint32_t of_far(std::size_t index) const { return far_sets_[index]; }

 private:
  // A component of a rank's parts: their number among those of all ranks, in the order of the ranks.
  struct Joint {
    std::uint32_t a;
    std::uint32_t b;
    friend bool operator==(const Joint&, const Joint&) = default;
  };

  // Replaces each set by its number among the roots, in the order of their first vertices. Returns these vertices.
  [[nodiscard]] std::vector<std::uint32_t> number_own();
  // Joins the components of all ranks; `firsts` are the first vertices of those of this rank.
  [[nodiscard]] Result<void> number_all(const std::vector<std::uint32_t>& firsts, Ranks& ranks);
  // Returns the components of other ranks at the far vertices, and adds those that this rank joins to its own.
  [[nodiscard]] Result<std::vector<Joint>> join_far(std::span<const std::uint32_t> offsets, std::uint32_t end,
                                                    Ranks& ranks);

  std::span<const std::uint32_t> far_;
  std::string what_;
  Context context_;
  Reservation memory_;
  std::vector<std::uint32_t> sets_;      // per component of a part: its parent; after number(): its component
  std::vector<std::uint32_t> least_;     // per component of a part: its first vertex
  std::vector<std::size_t> ends_;        // end of the components of each part
  std::vector<std::uint32_t> far_sets_;  // of each far vertex
  std::uint64_t carried_from_ = 0;       // the first vertex in carried_
  std::vector<std::uint32_t> carried_;   // the sets of the last part's vertices, its own and those of the next part
  std::uint32_t count_ = 0;
};

}  // namespace isoextract::mesh
