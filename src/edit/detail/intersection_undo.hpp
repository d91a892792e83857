// Undoes collapses that made triangles intersect.
//
// Collapses see only the triangles of their patch (intersection_guard.hpp), and an undone collapse brings triangles
// back among changed ones. So triangles of different patches, and triangles that came back, can still intersect.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "edit/detail/collapse_state.hpp"

namespace isoextract::edit {

// Returns the bytes that undo_intersections() reserves for a mesh with so many triangles.
[[nodiscard]] std::uint64_t intersection_search_bytes(std::uint64_t triangles);

struct UndoneIntersections {
  std::uint64_t collapses = 0;
  std::vector<RestoredTriangle> restored;  // as undo_collapse() lists them
};

// Undoes collapses until no new pair of triangles intersects: for each pair, the latest collapse that changed one of
// the two. A pair is not new if both triangles are original, or if both are CollapseState::tangled. `restored` are the
// triangles that undone collapses have brought back: with `is_first` since edges were collapsed, else since the last
// check. Without `is_first`, looks only at pairs with such a triangle. `logs` are sorted by `first`; `name` is that of
// the mesh, for messages. The result does not depend on the number of threads. Fails with ErrorCode::out_of_memory or
// ErrorCode::cancelled.
[[nodiscard]] Result<UndoneIntersections> undo_intersections(CollapseState& state, std::span<const CollapseLog> logs,
                                                             std::span<const RestoredTriangle> restored, bool is_first,
                                                             const std::string& name, const Context& context);

}  // namespace isoextract::edit
