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

// "gaussian:2": how people write it.
[[nodiscard]] std::string text_of(const FilterStep& step);

// Applies one filter after the other to `field`, and tells of each. Fails with ErrorCode::input where it is no narrow
// band of a level set: a density, or samples that are not sparse; and as volume_io::filter_level_set() does.
[[nodiscard]] Result<void> filter_field(const std::vector<FilterStep>& steps, const std::string& label,
                                        const Context& context, Events& events, field::ScalarField& field);

}  // namespace isoextract::convert
