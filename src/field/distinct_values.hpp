// The distinct values of a field's samples.
#pragma once

#include <vector>

#include "base/progress.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// Returns the finite stored values in ascending order, without duplicates. Leaves out the background of a sparse field.
[[nodiscard]] std::vector<double> distinct_values(const ScalarField& field, Progress* progress = nullptr);

}  // namespace isoextract::field
