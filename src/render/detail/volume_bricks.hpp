// Finds the bricks of cells that have visible samples.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "render/detail/volume_samples.hpp"

namespace isoextract::render::detail {

// Brick b holds the cells from 8 b on, 8 per axis; it shares the samples of its upper faces with the next bricks. A
// brick is invisible if every lookup between its least and its greatest sample has sigma 0. NaN samples have sigma 0.
//
// For sparse fields only bricks around stored blocks are listed. Any other brick has the constant values of tiles or
// background at its corners, and is_visible() looks these up on demand.
class VolumeBricks {
 public:
  static constexpr int kCells = 8;

  // Reads all samples. `samples` must outlive the result, which holds its memory reservation. Fails as
  // Context::reserve() and Context::check() do.
  [[nodiscard]] static Result<VolumeBricks> measure(const VolumeSamples& samples, const Context& context);

  [[nodiscard]] bool is_visible(const glm::ivec3& brick) const;
  [[nodiscard]] std::uint64_t count() const { return seen_.size(); }
  [[nodiscard]] std::uint64_t count_invisible() const;

 private:
  explicit VolumeBricks(const VolumeSamples& samples) : samples_(&samples) {}

  const VolumeSamples* samples_;
  glm::i64vec3 dims_{0};             // dense fields: number of bricks
  field::OriginIndex index_;         // sparse fields: brick number by origin
  std::vector<glm::ivec3> origins_;  // sparse fields
  std::vector<std::uint8_t> seen_;
  Reservation memory_;
};

}  // namespace isoextract::render::detail
