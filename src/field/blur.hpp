// Noise filters: weighted means and medians of the samples around each sample.
#pragma once

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// The largest supported filter sizes, in voxels: a standard deviation, and a radius (half the side of a box).
inline constexpr double kMaxBlurSigma = 16;
inline constexpr int kMaxMedianRadius = 8;

// Filters with a Gaussian whose standard deviations along the grid axes are `sigma`, in voxels. Each lies in [0,
// kMaxBlurSigma]; 0 leaves that axis unfiltered. The kernel reaches ceil(3 `sigma`) voxels. The result is f64 for
// f64, u32 and i32 samples, else f32. It is the same for any number of threads.
//
// Samples that are not finite and positions outside dense data get no weight (normalized convolution). Samples that are
// not finite keep their value, so that a later NanPolicy applies to the same samples. Where all samples within reach
// are equal, the value does not change at all.
//
// A sparse field stays sparse. Filters tiles and the background like other values. For a narrow band this means: the
// filter does not recompute distances, and values farther from the band than the kernel reaches do not change. The
// result has a block wherever the kernel reaches (a) a block of the input or (b) a face between a tile and a different
// value. `active_box` and `active_voxels` do not change.
//
// Fails with ErrorCode::usage if `sigma` is out of range, with ErrorCode::out_of_memory, and if the context is
// cancelled.
[[nodiscard]] Result<ScalarField> blur_gaussian(const ScalarField& field, const glm::dvec3& sigma,
                                                const Context& context);

// Replaces each sample by the median of the samples at most `radius` (1 to kMaxMedianRadius) voxels away along each
// axis: the box has 2 `radius` + 1 samples a side. Of an even count, takes the lower of the two middle samples. Ignores
// NaN and positions outside dense data. NaN samples stay NaN. The samples keep their type. Treats sparse fields as
// blur_gaussian() does. Fails with ErrorCode::usage if `radius` is out of range, with ErrorCode::out_of_memory, and if
// the context is cancelled.
[[nodiscard]] Result<ScalarField> blur_median(const ScalarField& field, int radius, const Context& context);

}  // namespace isoextract::field
