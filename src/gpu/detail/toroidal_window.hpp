// A window over data that do not fit in memory, kept in an array with wrapping addresses: samples that stay in the
// window are never moved or copied again. D. A. Shustikov: Use of toroidal copying for stepwise updates of a texture
// (docs/papers.md), extended to three dimensions. A window one sample thick in z is the case of the paper.
#pragma once

#include <optional>
#include <vector>

#include "field/samples.hpp"

namespace isoextract::gpu {

class ToroidalWindow {
 public:
  // Starts empty: the first move makes all samples new.
  explicit ToroidalWindow(const glm::ivec3& size) : size_(size) {}

  [[nodiscard]] const glm::ivec3& size() const { return size_; }

  // Returns the texel of sample `p`, whose coordinates must not be negative.
  [[nodiscard]] glm::ivec3 texel(const glm::ivec3& p) const { return p % size_; }

  // Moves the window so that it begins at `low`. Returns the boxes of samples that entered it: disjoint, at most three
  // after the first move.
  [[nodiscard]] std::vector<field::IndexBox> move_to(const glm::ivec3& low);

  // Splits a box in the window into boxes that are contiguous in the array.
  [[nodiscard]] std::vector<field::IndexBox> pieces(const field::IndexBox& box) const;

 private:
  glm::ivec3 size_;
  std::optional<glm::ivec3> low_;
};

}  // namespace isoextract::gpu
