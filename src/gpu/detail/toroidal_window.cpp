#include "gpu/detail/toroidal_window.hpp"

namespace isoextract::gpu {

std::vector<field::IndexBox> ToroidalWindow::move_to(const glm::ivec3& low) {
  field::IndexBox rest{low, low + size_ - 1};
  std::vector<field::IndexBox> entered;
  if (!low_) {
    entered.push_back(rest);
  } else {
    const field::IndexBox old{*low_, *low_ + size_ - 1};
    // Axis by axis: the part beyond the old window enters; the rest is split along the next axis.
    for (int axis = 0; axis < 3 && !rest.empty(); ++axis) {
      field::IndexBox fresh = rest;
      if (rest.min[axis] < old.min[axis]) {
        fresh.max[axis] = std::min(rest.max[axis], old.min[axis] - 1);
        rest.min[axis] = fresh.max[axis] + 1;
      } else {
        fresh.min[axis] = std::max(rest.min[axis], old.max[axis] + 1);
        rest.max[axis] = fresh.min[axis] - 1;
      }
      if (!fresh.empty()) entered.push_back(fresh);
    }
  }
  low_ = low;
  return entered;
}

std::vector<field::IndexBox> ToroidalWindow::pieces(const field::IndexBox& box) const {
  std::vector<field::IndexBox> whole{box};
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<field::IndexBox> cut;
    for (field::IndexBox part : whole) {
      const int seam = (part.min[axis] / size_[axis] + 1) * size_[axis];  // first sample whose address wraps to 0
      if (part.max[axis] >= seam) {
        field::IndexBox before = part;
        before.max[axis] = seam - 1;
        cut.push_back(before);
        part.min[axis] = seam;
      }
      cut.push_back(part);
    }
    whole = std::move(cut);
  }
  return whole;
}

}  // namespace isoextract::gpu
