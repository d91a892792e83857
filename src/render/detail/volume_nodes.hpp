// Which bricks of a volume a device needs, and where they are in its atlas.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "render/detail/volume_bricks.hpp"
#include "render/detail/volume_samples.hpp"

namespace isoextract::render::detail {

// Bricks of 8 x 8 x 8 cells in nodes of 16 x 16 x 16 bricks. A brick has 9 samples a side: neighbours share those at
// their borders. Those that have one value, because nothing but tiles or background is around, share a slot with all
// others of it, and so do whole nodes.
class VolumeNodes {
 public:
  static constexpr int kSide = 16;  // of a node, in bricks
  static constexpr int kCells = kSide * VolumeBricks::kCells;
  static constexpr std::int32_t kUnseen = -1;

  // Of the cells from `first` to `last`. `bricks` may be null: then all are needed. Memory is reserved for as long as
  // this lives.
  [[nodiscard]] static Result<VolumeNodes> list(const VolumeSamples& samples, const VolumeBricks* bricks,
                                                const glm::ivec3& first, const glm::ivec3& last,
                                                const Context& context);

  [[nodiscard]] const glm::ivec3& first() const { return first_; }  // in nodes
  [[nodiscard]] const glm::ivec3& dims() const { return dims_; }
  // x fastest: the node's number, kUnseen, or ~(slot + 1) of a slot for all of it.
  [[nodiscard]] const std::vector<std::int32_t>& nodes() const { return nodes_; }
  // Of each node, z fastest: the brick's slot, or kUnseen.
  [[nodiscard]] const std::vector<std::int32_t>& bricks() const { return bricks_; }
  // The least sample of a brick with the slot's values.
  [[nodiscard]] const std::vector<glm::ivec3>& slots() const { return slots_; }

 private:
  static constexpr std::int32_t kOwn = 0;       // while they are listed: has a slot of its own
  static constexpr std::int32_t kConstant = 1;  // likewise: shares one
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
