// The stage that filters level sets.
#pragma once

#include <cstdint>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// Returns "gaussian:2", the form of the command line.
[[nodiscard]] std::string text_of(const FilterStep& step);

// Applies the filters to `field` in order, and reports each. Fails with ErrorCode::input for densities and dense
// samples, because only the narrow band of a level set can be filtered, and as volume_io::filter_level_set() does.
// Without steps, does nothing to any field.
[[nodiscard]] Result<void> filter_field(const std::vector<FilterStep>& steps, const std::string& label,
                                        const Context& context, Events& events, field::ScalarField& field);

}  // namespace isoextract::convert
