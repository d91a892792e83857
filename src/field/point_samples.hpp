// Values of a field at given world positions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {

struct PointCounts {
  std::uint64_t outside = 0;     // positions outside dense samples by more than a thousandth of a voxel
  std::uint64_t not_finite = 0;  // values that are NaN, infinite or beyond the range of float32
};

// Evaluates the trilinear interpolant of a field, with its value scale, at world positions. Samples of weight 0 are
// ignored, as in resample(); a NaN with weight gives NaN.
//
// A position outside dense samples gets the value at the nearest position of their box. Along an axis with one sample,
// all positions get the value at this sample. A sparse field has no bounds: positions outside its blocks and tiles get
// the background. A position whose index has a NaN gives NaN.
class PointSampler {
 public:
  // Makes the lookup table that finds sparse blocks, and holds a reservation for it. `field` must outlive the sampler.
  // Fails with ErrorCode::out_of_memory.
  [[nodiscard]] static Result<PointSampler> make(const ScalarField& field, const Context& context);

  // Writes the value at places[i] to values[stride * i]. `values` needs at least stride * (places - 1) + 1 elements;
  // elements between the results are not written. The result is the same for any number of threads, and several threads
  // may call it at once. Fails as Context::check() does.
  [[nodiscard]] Result<PointCounts> sample(std::span<const glm::dvec3> places, std::span<float> values,
                                           std::size_t stride, const Context& context) const;

 private:
  explicit PointSampler(const ScalarField& field) : field_(&field), index_of_world_(field.index_to_world.inverse()) {}

  const ScalarField* field_;
  Affine index_of_world_;
  Reservation memory_;
  std::optional<SparseLookup> lookup_;  // of a sparse field
};

// Samples `field` at `places` once, as PointSampler does.
[[nodiscard]] Result<PointCounts> sample_points(const ScalarField& field, std::span<const glm::dvec3> places,
                                                std::span<float> values, std::size_t stride, const Context& context);

}  // namespace isoextract::field
