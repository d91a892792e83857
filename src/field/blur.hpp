// Fields without their noise: weighted means and medians of the samples around each sample.
#pragma once

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// The widest that are taken, in voxels.
inline constexpr double kMaxBlurSigma = 16;
inline constexpr int kMaxMedianWidth = 8;

// A Gaussian of these standard deviations along the axes of the grid, in voxels, each from 0 (nothing is done along
// that axis) to kMaxBlurSigma. It ends at three of them. Samples are f64 if they were f64, u32 or i32, and otherwise
// f32.
//
// Where there are no samples there is nothing to be weighed: beyond the data, and where a sample is not finite. The
// others around them have all the weight. A sample that is not finite stays what it was, so that what is done with NaN
// is done with the same samples. Where all samples around are alike, the value is exactly theirs.
//
// Sparse stays sparse. Tiles and the background are values like any other, those of a narrow band too: far from its
// surface a level set stays constant, and no distances are made anew. Blocks come about where a stored value reaches.
// Which voxels are active stays as it was.
//
// Fails with ErrorCode::usage for other deviations, with ErrorCode::input where the memory is not there, and where the
// context is cancelled. The same for any number of threads.
[[nodiscard]] Result<ScalarField> blur_gaussian(const ScalarField& field, const glm::dvec3& sigma,
                                                const Context& context);

// The median of the samples up to `width` (1 to kMaxMedianWidth) voxels away along each axis, the lower one of an even
// number; of those that are in the data, and no NaN. NaN stays. Samples keep their type. Everything else is as above.
[[nodiscard]] Result<ScalarField> blur_median(const ScalarField& field, int width, const Context& context);

}  // namespace isoextract::field
