// Labels of a map of which a coarser grid has no sample.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "convert/events.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// Notes and reports the labels of `map`, except `background`, that `grid` lacks. For jobs that ask for all labels.
void tell_lost_labels(const field::ScalarField& map, const field::ScalarField& grid, std::int64_t background,
                      const Context& context, Events& events);

}  // namespace isoextract::convert
