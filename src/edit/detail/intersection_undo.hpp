// Undoes collapses that made triangles intersect.
//
// The guard of collapses sees only the triangles of their patch (intersection_guard.hpp), some rounds have no guard,
// and an undone collapse brings triangles back among changed ones. So triangles can intersect after a round.
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
  std::uint64_t patches = 0;               // logs undone as a whole
  std::vector<RestoredTriangle> restored;  // as undo_collapse() lists them
};

// The pairs of triangles that a search for intersections skips.
enum class SkippedPairs : std::uint8_t {
  none,
  within_a_patch,             // the guard tested them
  without_restored_triangle,  // an earlier call tested them
};

// Undoes collapses until no new pair of triangles intersects: for each pair, the latest collapse that changed one of
// the two. A pair is not new if both triangles are original, if both are CollapseState::tangled, or if neither is
// CollapseState::is_unchecked() or restored. `restored` are the triangles that undone collapses have brought back since
// edges were collapsed or since the last call. `logs` are sorted by `first`; `name` is that of the mesh, for messages.
//
// With SkippedPairs::none, undoes all collapses of a log with very many pairs, for a guarded round to do again:
// triangles may have intersected before, and single undos would take very many passes.
//
// The result does not depend on the number of threads. Fails with ErrorCode::out_of_memory or ErrorCode::cancelled.
[[nodiscard]] Result<UndoneIntersections> undo_intersections(CollapseState& state, std::span<const CollapseLog> logs,
                                                             std::span<const RestoredTriangle> restored,
                                                             SkippedPairs skipped, const std::string& name,
                                                             const Context& context);

}  // namespace isoextract::edit
