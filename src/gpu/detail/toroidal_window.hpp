// A window over data that does not fit, kept in an array whose addresses repeat: what stays in the window is never
// moved or copied again. D. A. Shustikov: Use of toroidal copying for stepwise updates of a
// texture (docs/papers.md), in three dimensions; a window of one sample in z is the paper's own case.
#pragma once

#include <optional>
#include <vector>

#include "field/samples.hpp"

namespace isoextract::gpu {

class ToroidalWindow {
 public:
  // Empty at first: whatever it is moved to is new.
  explicit ToroidalWindow(const glm::ivec3& size) : size_(size) {}

  [[nodiscard]] const glm::ivec3& size() const { return size_; }

  // Where sample `p`, with no negative coordinate, is kept.
  [[nodiscard]] glm::ivec3 texel(const glm::ivec3& p) const { return p % size_; }

  // Lets the window begin at `low`. Returns what entered it: disjoint boxes, at most three after the first move.
  [[nodiscard]] std::vector<field::IndexBox> move_to(const glm::ivec3& low);

  // The parts of a box within the window that are kept in one piece.
  [[nodiscard]] std::vector<field::IndexBox> pieces(const field::IndexBox& box) const;

 private:
  glm::ivec3 size_;
  std::optional<glm::ivec3> low_;
};

}  // namespace isoextract::gpu
