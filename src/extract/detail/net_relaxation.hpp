// Smooths the points of a surface net within their cells.
//
// A round moves every point toward the mean of its connected points, then back from their new mean (Taubin: A signal
// processing approach to fair surface design. 1995). Rounds build up momentum, so that few of them do as much as many
// plain ones.
#pragma once

#include <cstdint>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "extract/detail/net_grid.hpp"

namespace isoextract::extract {

// The least distance of a point from the faces of its cell, in grid steps. It keeps triangles from losing their area.
inline constexpr float kNetMargin = 0.02F;
// The farthest that a point may be from its corner, along each axis.
inline constexpr float kNetReach = 0.5F - kNetMargin;

// Moves the points of `grid` in `rounds` rounds. `offsets` has the offset of each point from its corner, in grid steps,
// 0 before the call, and one unused element at the end, since load() reads 16 bytes. Runs in parallel; the result does
// not depend on the number of threads. Fails if memory runs out and if the context is cancelled.
[[nodiscard]] Result<void> relax_net(const NetGrid& grid, const LabelChunks& labels, std::uint64_t rounds,
                                     NetArray<glm::vec3>& offsets, NetMemory& memory);

// Returns the bytes that relax_net() takes while it runs.
[[nodiscard]] inline std::uint64_t relaxing_bytes(std::uint64_t points) {
  return points * (2 * sizeof(glm::vec3) + sizeof(std::uint8_t));
}

// Returns the axes, as bits, along which a corner is at the data boundary. Its point does not move along these axes.
[[nodiscard]] inline unsigned fixed_axes(const glm::ivec3& corner, const field::IndexBox& bounds) {
  unsigned axes = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (corner[axis] == bounds.min[axis] || corner[axis] == bounds.max[axis] + 1) axes |= 1U << axis;
  }
  return axes;
}

// Returns fixed_axes() for the corners of one row.
class RowFixedAxes {
 public:
  // `first`: the first corner of the row.
  RowFixedAxes(const glm::ivec3& first, const field::IndexBox& bounds)
      : all_(fixed_axes({bounds.min.x - 1, first.y, first.z}, bounds)),
        lowest_(bounds.min.x - first.x),
        highest_(bounds.max.x + 1 - first.x) {}

  [[nodiscard]] unsigned at(int bit) const { return all_ | (bit == lowest_ || bit == highest_ ? 1U : 0U); }

 private:
  unsigned all_;  // y and z bits, equal for all corners of the row
  int lowest_;
  int highest_;
};

[[nodiscard]] inline glm::vec3 without_axes(glm::vec3 offset, unsigned axes) {
  for (int axis = 0; axes != 0; ++axis, axes >>= 1) {
    if ((axes & 1) != 0) offset[axis] = 0;
  }
  return offset;
}

// Returns the allowed offset of a point that is nearest to `offset`: within the cell, and 0 along the fixed `axes`.
[[nodiscard]] inline glm::vec3 offset_within_cell(const glm::vec3& offset, unsigned axes) {
  return without_axes(glm::clamp(offset, -kNetReach, kNetReach), axes);
}

}  // namespace isoextract::extract
