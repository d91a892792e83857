// Affine maps in double precision: index -> world, world -> output.
#pragma once

#include <cmath>
#include <limits>

#include <glm/glm.hpp>

#include "base/finite.hpp"

namespace isoextract::field {

// Maps p to linear * p + offset. GLM matrices are column-major: linear[a] is the image of the unit vector along axis a.
struct Affine {
  glm::dmat3 linear{1.0};
  glm::dvec3 offset{0.0};

  [[nodiscard]] glm::dvec3 operator()(const glm::dvec3& p) const { return linear * p + offset; }

  // Returns the map p -> (*this)(inner(p)).
  [[nodiscard]] Affine after(const Affine& inner) const {
    return {linear * inner.linear, linear * inner.offset + offset};
  }

  [[nodiscard]] double determinant() const { return glm::determinant(linear); }

  [[nodiscard]] Affine inverse() const {
    const glm::dmat3 inverted = glm::inverse(linear);
    return {inverted, -(inverted * offset)};
  }

  // Returns whether the map can be inverted safely: its entries are finite and its determinant is not zero relative to
  // the lengths of the axes.
  [[nodiscard]] bool is_invertible() const {
    const double scale = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
    return is_finite(offset) && std::isfinite(scale) && scale > 0 && std::abs(determinant()) > 1e-12 * scale;
  }

  friend bool operator==(const Affine&, const Affine&) = default;
};

// A box in world or index coordinates; both corners belong to it.
struct Box {
  glm::dvec3 min{0.0};
  glm::dvec3 max{0.0};

  friend bool operator==(const Box&, const Box&) = default;
};

// Returns the bounding box of `map` applied to `box`.
[[nodiscard]] inline Box image_of(const Affine& map, const Box& box) {
  Box image{glm::dvec3(std::numeric_limits<double>::infinity()), glm::dvec3(-std::numeric_limits<double>::infinity())};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p = map({(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                              (corner & 4) != 0 ? box.max.z : box.min.z});
    image.min = glm::min(image.min, p);
    image.max = glm::max(image.max, p);
  }
  return image;
}

[[nodiscard]] inline Affine scaling(const glm::dvec3& factors) {
  return {glm::dmat3(factors.x, 0, 0, 0, factors.y, 0, 0, 0, factors.z), glm::dvec3(0)};
}

}  // namespace isoextract::field
