// The distinct values of a field's samples.
#pragma once

#include <vector>

#include "base/progress.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// Returns the finite stored (unscaled) values in ascending order, without duplicates. Of a sparse field, leaves out all
// samples equal to the background, and in a level set also those equal to its negative. Reserves no memory.
[[nodiscard]] std::vector<double> distinct_values(const ScalarField& field, Progress* progress = nullptr);

}  // namespace isoextract::field
