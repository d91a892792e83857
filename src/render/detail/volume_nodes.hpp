// Selects the bricks of a volume that a device needs, and assigns their slots in its atlas.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "render/detail/volume_bricks.hpp"
#include "render/detail/volume_samples.hpp"

namespace isoextract::render::detail {

// A two-level table: nodes of 16 x 16 x 16 bricks of 8 x 8 x 8 cells. A brick has 9 samples per axis; adjacent bricks
// share the samples of their common face. All bricks that have the same constant value, from tiles or the background,
// share a slot. A node with only one such value is stored as that slot.
class VolumeNodes {
 public:
  static constexpr int kSide = 16;  // bricks per axis of a node
  static constexpr int kCells = kSide * VolumeBricks::kCells;
  static constexpr std::int32_t kInvisible = -1;

  // Lists the visible bricks of the cells from `first` to `last`, or all bricks if `bricks` is null. The result holds
  // its memory reservation. Fails with ErrorCode::unavailable for 2^31 bricks or more, and as Context::reserve() does.
  [[nodiscard]] static Result<VolumeNodes> list(const VolumeSamples& samples, const VolumeBricks* bricks,
                                                const glm::ivec3& first, const glm::ivec3& last,
                                                const Context& context);

  [[nodiscard]] const glm::ivec3& first() const { return first_; }  // in nodes
  [[nodiscard]] const glm::ivec3& dims() const { return dims_; }
  // Returns, per node, x fastest: its number in bricks(), kInvisible, or ~(slot + 1) if the whole node uses one slot.
  [[nodiscard]] const std::vector<std::int32_t>& nodes() const { return nodes_; }
  // Returns, per brick of each listed node, z fastest: its slot, or kInvisible.
  [[nodiscard]] const std::vector<std::int32_t>& bricks() const { return bricks_; }
  // Returns, per slot: the first sample of a brick with the slot's values.
  [[nodiscard]] const std::vector<glm::ivec3>& slots() const { return slots_; }

 private:
  static constexpr std::int32_t kOwn = 0;       // while listing: has its own slot
  static constexpr std::int32_t kConstant = 1;  // while listing: shares a slot
  static constexpr std::size_t kBricks = std::size_t{kSide} * kSide * kSide;

  class Lister;

  glm::ivec3 first_{0};
  glm::ivec3 dims_{0};
  std::vector<std::int32_t> nodes_;
  std::vector<std::int32_t> bricks_;
  std::vector<glm::ivec3> slots_;
  Reservation memory_;
};

}  // namespace isoextract::render::detail
