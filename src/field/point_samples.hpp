// Values of a field at given world positions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

struct PointCounts {
  std::uint64_t outside = 0;     // positions outside dense samples by more than a thousandth of a voxel
  std::uint64_t not_finite = 0;  // values that are NaN, infinite or beyond the range of float32
};

// Evaluates the trilinear interpolant of `field`, with its value scale, at the world positions `places`: the value at
// places[i] goes to values[stride * i]. Samples of weight 0 are ignored, as in resample(); a NaN with weight gives NaN.
//
// A position outside dense samples gets the value at the nearest position of their box. Along an axis with one sample,
// all positions get the value at this sample. A sparse field has no bounds: positions outside its blocks and tiles get
// the background. A position whose index has a NaN gives NaN.
//
// The result is the same for any number of threads. `values` needs at least stride * (places - 1) + 1 elements;
// elements between the results are not written. Reserves memory to find sparse blocks while it runs. Fails with
// ErrorCode::out_of_memory and as Context::check() does.
[[nodiscard]] Result<PointCounts> sample_points(const ScalarField& field, std::span<const glm::dvec3> places,
                                                std::span<float> values, std::size_t stride, const Context& context);

}  // namespace isoextract::field
