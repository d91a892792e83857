// Finds labels of a map that a coarser grid loses, because none of its samples has them.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "convert/events.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// Notes and reports the labels of `map`, except `background`, that `grid` lacks. Call it only if the job asks for all
// of its labels.
void tell_lost_labels(const field::ScalarField& map, const field::ScalarField& grid, std::int64_t background,
                      const Context& context, Events& events);

}  // namespace isoextract::convert
