// Samples of a label map that are no labels.
#pragma once

#include <glm/glm.hpp>

#include "field/label_value.hpp"

namespace isoextract::extract {

using field::is_label;
using field::largest_label;

// A sample that is not a label.
struct NonLabelSample {
  double value = 0;
  glm::ivec3 at{0};
};

}  // namespace isoextract::extract
