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

// The pairs of triangles that a search for intersections skips.
enum class UnlikelyPairs : std::uint8_t {
  none,
  of_one_patch,  // the guard has tested them
  not_restored,  // neither triangle is restored; all others have been tested
};

// Undoes collapses until no new pair of triangles intersects: for each pair, the latest collapse that changed one of
// the two. A pair is not new if both triangles are original, if both are CollapseState::tangled, or if neither is
// CollapseState::is_unchecked() or restored. `restored` are the triangles that undone collapses have brought back since
// edges were collapsed or since the last call. `logs` are sorted by `first`; `name` is that of the mesh, for messages.
// The result does not depend on the number of threads. Fails with ErrorCode::out_of_memory or ErrorCode::cancelled.
[[nodiscard]] Result<UndoneIntersections> undo_intersections(CollapseState& state, std::span<const CollapseLog> logs,
                                                             std::span<const RestoredTriangle> restored,
                                                             UnlikelyPairs skipped, const std::string& name,
                                                             const Context& context);

}  // namespace isoextract::edit
