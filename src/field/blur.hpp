// Noise filters: weighted means and medians of the samples around each sample.
#pragma once

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// The largest supported filter sizes, in voxels.
inline constexpr double kMaxBlurSigma = 16;
inline constexpr int kMaxMedianWidth = 8;

// Filters with a Gaussian whose standard deviations along the grid axes are `sigma`, in voxels. Each lies in [0,
// kMaxBlurSigma]; 0 leaves that axis unfiltered. The kernel ends at three standard deviations. The result is f64 for
// f64, u32 and i32 samples, else f32. It is the same for any number of threads.
//
// Samples that are not finite and positions outside dense data get no weight (normalized convolution). Samples that are
// not finite keep their value, so that the handling of NaN applies to the same samples. Where all samples within reach
// are equal, the value does not change at all.
//
// A sparse field stays sparse. Tiles and the background count as ordinary values, also those of a narrow band: the
// filter does not recompute distances, and a level set stays constant away from its surface. The result has a block
// wherever a stored value can reach. The record of active voxels does not change.
//
// Fails with ErrorCode::usage if `sigma` is out of range, with ErrorCode::out_of_memory, and if the context is
// cancelled.
[[nodiscard]] Result<ScalarField> blur_gaussian(const ScalarField& field, const glm::dvec3& sigma,
                                                const Context& context);

// Replaces each sample by the median of the samples at most `width` (1 to kMaxMedianWidth) voxels away along each axis;
// the lower median of an even number. Ignores NaN and positions outside dense data. NaN samples stay NaN. The samples
// keep their type. Otherwise as blur_gaussian().
[[nodiscard]] Result<ScalarField> blur_median(const ScalarField& field, int width, const Context& context);

}  // namespace isoextract::field
