// Resampling to another resolution: a mean where the grid gets coarser, an interpolation kernel where it gets finer.
#pragma once

#include <array>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// How a finer grid interpolates along each axis.
enum class ResampleKernel {
  linear,    // linear interpolation of the two neighbors
  cubic,     // Catmull and Rom 1974: passes through the samples, with continuous slope; may overshoot beside steps
  bspline,   // cubic B-spline with the samples as coefficients: smoother, does not pass through the samples
  nearest,   // the nearest sample, on a tie the lower index; also on coarser grids, without means
  majority,  // nearest; on coarser grids the value of most voxels, as labels must not be averaged
};
constexpr auto words_of(ResampleKernel /*type*/) {
  return std::array{Word{ResampleKernel::linear, "linear"}, Word{ResampleKernel::cubic, "cubic"},
                    Word{ResampleKernel::bspline, "bspline"}, Word{ResampleKernel::nearest, "nearest"},
                    Word{ResampleKernel::majority, "majority"}};
}

// How averages treat NaN samples.
enum class NanHandling {
  left_out,  // the other samples get all the weight; a new sample is NaN if NaN has more than half of its weight
  spread,    // a new sample is NaN if a NaN has nonzero weight in it: for callers that treat NaN as an error
};

// Returns `field` on a dense grid of `resolution` samples that covers the same box: along each axis the first and last
// samples of both grids coincide. Adjusts `index_to_world` and `index_to_file`. The result has the notes of this
// function only, and is the same for any number of threads.
//
// Along an axis that gets more samples, a new sample is the kernel's value at its position. Along an axis that gets
// fewer, it is the mean of the old voxels (boxes around the samples) over an interval of one new step, centered at it.
// A voxel that is partly within the interval has that part of the weight. This is the box filter of coarsen(), for any
// step. Away from the boundary the intervals tile the axis, so each sample counts once. Constants keep their values,
// and so do linear functions if the step is a whole number of voxels. Other steps shift a linear function by at most
// 1 / (8 * step) voxels. Near the boundary the averaged interval shrinks symmetrically, down to the boundary sample
// itself, so some samples there count less or not at all.
//
// The result is f64 for f64, u32 and i32 samples, which float cannot hold exactly, else f32. It resamples stored values
// and keeps the value scale. Kernels that pass through the samples keep old values exactly: along an axis that does not
// get fewer samples, a new sample at the position of an old one has the old value. The first and last samples along any
// axis keep their values along that axis. A dense field that already has the resolution shares its samples, in their
// own type, unless the kernel is bspline.
//
// Samples of weight 0 are ignored. Except with cubic, a value lies between the smallest and the largest sample used,
// even if their difference overflows. `nan` decides about NaN; an infinite sample gives that infinity, and both
// infinities give NaN. Beside samples that are not finite, cubic and bspline interpolate linearly.
//
// With ResampleKernel::nearest and majority each new sample is one of the old samples, in their type, for any
// resolution. majority takes the value with the most weight in the interval that a mean would average. In a tie, the
// value of the nearest sample wins if it takes part, else the least value. Along axes that do not get fewer samples it
// takes the nearest sample. NaN counts as a value; it loses a tie unless the nearest sample is NaN. With
// NanHandling::spread, NaN in the interval gives NaN.
//
// A sparse field has no bounds. Its box here contains the active voxels and all stored values that differ from the
// background, plus one voxel on each side; outside it and on its faces everything is background. The result is dense,
// in reserved memory, and a note tells its size. If the box has more than 2^35 voxels, averaging would
// take minutes: the result then holds interpolated values, or with majority nearest samples, and another note says so.
//
// Fails with ErrorCode::usage if `resolution` is below 2 along an axis, with ErrorCode::input if a dense `field` has
// fewer than 2 samples along an axis, with ErrorCode::out_of_memory, and as Context::check() does.
[[nodiscard]] Result<ScalarField> resample(const ScalarField& field, const glm::ivec3& resolution,
                                           ResampleKernel kernel, NanHandling nan, const Context& context);

// Returns the box of samples that resample() covers: all samples of a dense field. May read all samples of a sparse
// field.
[[nodiscard]] IndexBox resampled_box(const ScalarField& field);

// Returns a resolution whose steps are about `voxel_size` (edge lengths in world units, along the axes of the field).
// Rounds the number of steps in the box of resample() to a whole number, so that nothing is cut off. May read all
// samples of a sparse field to find its box.
//
// Fails with ErrorCode::usage if a length is not above 0 or is more than twice the box's length along its axis, or if
// an axis would have more samples than an int holds. Fails with ErrorCode::input if a dense `field` has only one sample
// along an axis.
[[nodiscard]] Result<glm::ivec3> resolution_of_voxel_size(const ScalarField& field, const glm::dvec3& voxel_size);

}  // namespace isoextract::field
