// Values of a field at given places of the world.
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
  std::uint64_t outside = 0;     // of dense samples, by more than a thousandth of a voxel
  std::uint64_t not_finite = 0;  // values that are NaN, infinite, or beyond float32
};

// The trilinear interpolant of `field`, by its value scale, at `places` of the world: that of place i becomes
// values[stride * i]. Only neighbours that count have a say, as in resample(): NaN among them gives NaN.
//
// Outside of dense samples a place has the value at the nearest place of their box; along an axis of one sample every
// place has that. Sparse samples are everywhere, so beyond the stored ones it is their background.
//
// The same bits for any number of threads. Reserves and takes memory to find sparse blocks, for as long as it works.
// `values` has at least stride * (places - 1) + 1 elements; the others are left alone. Fails with ErrorCode::input
// where the memory is not there, and as Context::check() does.
[[nodiscard]] Result<PointCounts> sample_points(const ScalarField& field, std::span<const glm::dvec3> places,
                                                std::span<float> values, std::size_t stride, const Context& context);

}  // namespace isoextract::field
