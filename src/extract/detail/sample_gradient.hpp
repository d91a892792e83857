// Gradients of dense samples.
#pragma once

#include <cstdint>
#include <limits>

#include <glm/glm.hpp>

#include "extract/dense_masks.hpp"
#include "extract/edge_geometry.hpp"

namespace isoextract::extract {

template <class T>
[[nodiscard]] double axis_derivative(const T* center, std::int64_t stride, int index, int size) {
  const auto at = [&](int steps) { return static_cast<double>(center[steps * stride]); };
  if (index > 0 && index + 1 < size) return sample_derivative(at(-1), at(0), at(1));
  const int inward = index == 0 ? 1 : -1;
  const double far = size == 2 ? std::numeric_limits<double>::quiet_NaN() : at(2 * inward);
  return inward * boundary_derivative(at(0), at(inward), far);
}

// Returns the gradient of the stored numbers at sample `p`: central differences, or one-sided ones of the same order at
// the data boundary (sample_derivative(), boundary_derivative()).
template <class T>
[[nodiscard]] glm::dvec3 sample_gradient(const DenseView<T>& view, const glm::ivec3& p) {
  const T* center = view.row(p.y, p.z) + p.x;
  return {axis_derivative(center, 1, p.x, view.dims.x), axis_derivative(center, view.stride_y, p.y, view.dims.y),
          axis_derivative(center, view.stride_z, p.z, view.dims.z)};
}

}  // namespace isoextract::extract
