// A field on a grid of another resolution: means where it is coarser, a kernel between the samples where it is finer.
#pragma once

#include <array>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/words.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// What is between the samples, where a grid becomes finer: along each axis,
enum class ResampleKernel {
  linear,   // the line through the two samples beside it
  cubic,    // Catmull and Rom 1974: through the samples, smooth across them; it may overshoot beside steps
  bspline,  // the cubic B-spline with the samples as its coefficients: smoother, not through the samples
  nearest,  // the nearest sample, of two the lower one; also where the grid becomes coarser: ids are never averaged
};
constexpr auto words_of(ResampleKernel /*type*/) {
  return std::array{Word{ResampleKernel::linear, "linear"}, Word{ResampleKernel::cubic, "cubic"},
                    Word{ResampleKernel::bspline, "bspline"}, Word{ResampleKernel::nearest, "nearest"}};
}

// What becomes of samples that are NaN, where others are averaged with them.
enum class NanSamples {
  left_out,  // the others have all the weight; a new sample is NaN where more than half of its weight is that of NaN
  spread,    // every new sample that has weight of a NaN is NaN: for who takes NaN for an error
};

// `field` on a dense grid of `resolution` samples that covers the same box: along each axis its first sample is the
// field's first and its last the field's last. `index_to_world` and `index_to_file` follow. The same answer for any
// number of threads.
//
// Along axes that get more samples, a new one is the kernel's value at its place; along those that get fewer, the mean
// of the field's voxels, boxes around its samples, over the step of the new grid around it, cut voxels by what is in
// there: a box filter as coarsen() has it, for steps that need not be whole. The steps lie side by side, so that
// nothing is lost or counted twice, and where they are hardly longer than a voxel, means are hardly other than the line
// between two samples. Constants and, by whole steps, what is linear keep their values; other steps move a line by an
// eighth of a voxel, divided by the step, at most. Towards the border of the field, which has nothing beyond, the part
// that is averaged shrinks on both sides alike, to the sample itself.
//
// Samples are f64 if they were f64, u32 or i32, which float cannot hold, and otherwise f32: what lies between the
// samples is rounded as in any file of that type. It is the stored values that are taken; the value scale stays as it
// is. Where a kernel that goes through the samples, or a border, falls on one of the field's, the new one has exactly
// its value; and a dense field that has the resolution already shares its samples, in their own type, unless the kernel
// is bspline.
//
// Only samples that count have a say. But for cubic, a value lies between the least and the greatest of them, also
// where their difference leaves the range of numbers. NaN among them is treated as `nan` says, infinity gives that
// infinity, and both infinities give NaN; beside such samples all kernels are linear.
//
// With ResampleKernel::nearest each new sample is one of the field's and has its type, whatever the resolution.
//
// Sparse samples are everywhere, so their box is that of the active voxels and of all stored values that are not the
// background, with one voxel more on each side: there and beyond all is background. They become dense, and a note says
// how large; where the box is so large that means would take minutes, another says that values at the places of the new
// samples are taken. Their memory is reserved before it is taken.
//
// Fails with ErrorCode::usage where `resolution` is below 2 along an axis, with ErrorCode::input where `field` is, or
// where the memory for it is not there.
[[nodiscard]] Result<ScalarField> resample(const ScalarField& field, const glm::ivec3& resolution,
                                           ResampleKernel kernel, NanSamples nan, const Context& context);

// The resolution whose steps are as near to `voxel_size`, the lengths of a voxel's edges in world units, as steps can
// be that divide the box that resample() covers: so that nothing of it is left out. They are those of the field where
// they are asked for. Sparse samples are looked through for their box.
//
// Fails with ErrorCode::usage where a length is not above 0 or no two samples along an axis are so far apart, and where
// the samples along one are more than an int holds; with ErrorCode::input where `field` has but one along an axis.
[[nodiscard]] Result<glm::ivec3> resolution_of_voxel_size(const ScalarField& field, const glm::dvec3& voxel_size);

}  // namespace isoextract::field
