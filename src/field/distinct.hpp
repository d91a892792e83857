// Which values the samples of a field have.
#pragma once

#include <vector>

#include "base/progress.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// Each stored number that samples have and that is finite, once, in rising order; of a sparse field without its
// background.
[[nodiscard]] std::vector<double> distinct_values(const ScalarField& field, Progress* progress = nullptr);

}  // namespace isoextract::field
