// A field on a grid of another resolution.
#pragma once

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// The trilinear interpolant of `field`, sampled on a dense grid of `resolution` samples that covers the same box: along
// each axis its first sample is the field's first and its last the field's last. `index_to_world` and `index_to_file`
// follow. The same answer for any number of threads.
//
// Samples are f64 if they were f64, u32 or i32, which float cannot hold, and otherwise f32: what lies between the
// samples is rounded as in any file of that type. It is the stored values that are interpolated; the value scale stays
// as it is. Where a sample falls on one of the field's it has exactly its value, and a dense field that has the
// resolution already shares its samples, in their own type.
//
// Only neighbours that count have a say. A value lies between the least and the greatest of them, also where their
// difference leaves the range of numbers. NaN among them gives NaN, infinity gives that infinity, and both infinities
// give NaN.
//
// Sparse samples are everywhere, so their box is that of the active voxels and of all stored values that are not the
// background, with one voxel more on each side: there and beyond all is background. They become dense, and a note says
// how large. Their memory is reserved before it is taken.
//
// Fails with ErrorKind::usage where `resolution` is below 2 along an axis, with ErrorKind::input where `field` is, or
// where the memory for it is not there.
[[nodiscard]] Result<ScalarField> resample(const ScalarField& field, const glm::ivec3& resolution,
                                           const Context& context = Context());

}  // namespace isoextract::field
