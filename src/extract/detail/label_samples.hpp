// Samples of a label map that are no labels.
#pragma once

#include <glm/glm.hpp>

#include "field/label_value.hpp"

namespace isoextract::extract {

using field::is_label;
using field::largest_label;

// A sample that is not a label. `at` is its voxel index (dense: from the lowest sample of the region).
struct NonLabelSample {
  double value = 0;
  glm::ivec3 at{0};
};

}  // namespace isoextract::extract
