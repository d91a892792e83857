// The stage that blurs the field before extraction.
#pragma once

#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/events.hpp"
#include "convert/surface_edits.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// Returns "a Gaussian of 2 voxels", as work facts say it.
[[nodiscard]] std::string text_of(const BlurStep& step);

// Applies the steps to `field` in order, and reports each. Fails as blur_gaussian(), blur_median() and
// check_mapping_intact() do, and with ErrorCode::usage if the standard deviation of a Gaussian is more than
// field::kMaxBlurSigma voxels along an axis.
[[nodiscard]] Result<void> blur_field(const std::vector<BlurStep>& steps, const std::string& label,
                                      const Context& context, Events& events, field::ScalarField& field);

}  // namespace isoextract::convert
