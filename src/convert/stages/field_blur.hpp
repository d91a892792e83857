// The stage that blurs a field before its surface is looked for.
#pragma once

#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/events.hpp"
#include "convert/surface_edits.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// "gaussian of 2 voxels": as facts tell it.
[[nodiscard]] std::string text_of(const BlurStep& step);

// Does one step after the other to `field`, and tells of each. Fails as blur_gaussian() and blur_median() do, and with
// ErrorCode::usage where a width in world units is more voxels than they take.
[[nodiscard]] Result<void> blur_field(const std::vector<BlurStep>& steps, const std::string& label,
                                      const Context& context, Events& events, field::ScalarField& field);

}  // namespace isoextract::convert
