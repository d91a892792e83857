// Collapses edges of a small mesh, and takes all collapses back.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "edit/detail/edge_collapse.hpp"

namespace isoextract::test {

// Collapses all edges that the state allows within the distance, except those of locked vertices. Returns the triangles
// left. Expects that undoing restores the triangles of the state.
inline std::vector<glm::uvec3> collapse_and_undo(edit::CollapseState& state, const std::vector<char>& locked,
                                                 double distance) {
  using namespace edit;
  const auto triangles = state.corners;
  std::vector<std::uint32_t> patch(triangles.size());
  for (std::uint32_t t = 0; t < patch.size(); ++t) patch[t] = t;
  const std::vector<char> wanted(locked.size(), 1);
  CollapseLimits limits;
  limits.distance = distance;
  const std::vector<CollapseLog> logs{collapse_edges(state, patch, {locked, wanted}, limits, 0)};
  std::vector<glm::uvec3> left;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (state.gone[t] == 0) left.push_back(state.corners[t]);
  }
  std::vector<RestoredTriangle> changed;
  std::size_t undone = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    while (state.changed_by[t] != kNone) undone += undo_collapse(state.changed_by[t], state, logs, changed);
  }
  EXPECT_EQ(undone, logs[0].collapses.size());
  EXPECT_EQ(state.corners, triangles);
  EXPECT_EQ(std::count(state.gone.begin(), state.gone.end(), 0), static_cast<std::ptrdiff_t>(triangles.size()));
  return left;
}

}  // namespace isoextract::test
