// Finds a point where an interpolant is 0, near a given position. Searches along the gradient.
//
// At a point with value r, the first-order distance is |r| / |grad f|. The gradient is taken in the mesh's coordinates:
// it is a covector, mapped by the inverse transpose of the transform. This distance is the first guess of a search
// along the gradient's line, up to one voxel; where the line leaves dense data, the search follows the data boundary.
// If it finds nothing, or a point more than twice as far as the guess, the search also goes toward the cell corners of
// opposite sign. The point found is on the surface and in the data, but need not be the nearest.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "accuracy/crossing.hpp"
#include "accuracy/detail/largest_component.hpp"
#include "field/interpolant.hpp"

namespace isoextract::accuracy {

class GradientSearch {
 public:
  struct Found {
    std::optional<glm::dvec3> step;  // from the position to the surface, in index space; empty if not found
    double guess = 0;                // first-order distance in voxels; infinite if the gradient is zero
    bool is_nearest = false;         // true only if certain: no point of the surface is nearer by more than 2 %
  };

  // `shortest` is the least length of a one-voxel step, in the mesh's coordinates.
  GradientSearch(const field::Interpolant& interpolant, const field::ScalarField& field, const glm::dmat3& linear,
                 double shortest)
      : interpolant_(interpolant), field_(interpolant), linear_(linear), shortest_(shortest) {
    if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
      last_cell_ = dense->dims - 2;
      low_ = glm::dvec3(0);
      high_ = glm::dvec3(dense->dims - 1);
    }
    const glm::dmat3 inverse = glm::inverse(linear);
    metric_ = inverse * glm::transpose(inverse);
    for (int axis = 0; axis < 3; ++axis) width_[axis] = 1 / std::sqrt(metric_[axis][axis]);
  }

  // Searches from `position`, which may be outside the data; the surface ends with the data. Returns nothing if a
  // sample used there is not finite.
  std::optional<Found> operator()(const glm::dvec3& position) {
    const glm::dvec3 index = glm::clamp(position, low_, high_);
    const glm::dvec3 shift = index - position;
    std::optional<Found> found = search_from(index);
    if (!found || shift == glm::dvec3(0)) return found;
    if (found->step) *found->step += shift;
    found->guess = first_order(field_(position)).distance;
    found->is_nearest = false;
    return found;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static constexpr double kReach = 1;  // voxels

  struct FirstOrder {
    glm::dvec3 direction{0.0};    // unit step in index space along the world's gradient, toward the surface
    double distance = kInfinity;  // in voxels; infinite if the gradient is zero
  };

  [[nodiscard]] FirstOrder first_order(const field::Interpolated& here) const {
    const double largest = max_abs_component(here.gradient);
    if (!(largest > 0)) return {};
    // Scales the gradient first: its square may leave the range of double.
    const glm::dvec3 gradient = here.gradient / largest;
    const double residual = here.value;
    const glm::dvec3 direction = glm::normalize(metric_ * gradient) * (residual > 0 ? -1.0 : 1.0);
    return {direction, std::abs(residual / largest / glm::dot(gradient, direction))};
  }

  std::optional<Found> search_from(const glm::dvec3& index) {
    const field::Interpolated here = field_(index);
    const double residual = here.value;
    if (!std::isfinite(residual) || !std::isfinite(max_abs_component(here.gradient))) return std::nullopt;
    if (residual == 0) return Found{glm::dvec3(0), 0, true};
    std::optional<glm::dvec3> found;
    const FirstOrder first = first_order(here);
    if (first.direction != glm::dvec3(0)) found = search_in_data(index, first.direction, residual, first.distance);
    if (!found || glm::length(*found) > 2 * first.distance) search_to_corners(index, residual, found);
    constexpr double kNearEnough = 0.98;
    const double length = found ? glm::length(linear_ * *found) : 0;
    const bool nearest = found && least_distance(index, here, length) >= kNearEnough * length;
    return Found{found, first.distance, nearest};
  }

  // Returns a lower bound of the distance to the surface within `reach`: the residual divided by the largest slope,
  // which is the slope here plus the effect of second derivatives. Returns 0 if `reach` extends into other cells.
  [[nodiscard]] double least_distance(const glm::dvec3& index, const field::Interpolated& here, double reach) {
    const glm::ivec3 cell = interpolant_.cell_of(index);
    const glm::dvec3 t = index - glm::dvec3(cell);
    for (int axis = 0; axis < 3; ++axis) {
      if (!(std::min(t[axis], 1 - t[axis]) * width_[axis] > reach)) return 0;
    }
    const auto bend = field_.max_second_derivative(cell);
    if (!bend) return 0;
    const double largest = max_abs_component(here.gradient);
    const glm::dvec3 scaled = largest > 0 ? here.gradient / largest : glm::dvec3(0);
    const double slope = largest * std::sqrt(glm::dot(scaled, metric_ * scaled));
    return std::abs(here.value) / (slope + *bend * reach / (shortest_ * shortest_));
  }

  // Returns how far along `step` the data end.
  [[nodiscard]] double distance_to_boundary(const glm::dvec3& index, const glm::dvec3& step) const {
    double nearest = kInfinity;
    for (int axis = 0; axis < 3; ++axis) {
      if (step[axis] == 0) continue;
      nearest = std::min(nearest, ((step[axis] > 0 ? high_ : low_)[axis] - index[axis]) / step[axis]);
    }
    return std::max(nearest, 0.0);
  }

  // Searches along `step`. If the line leaves the data before it meets the surface, continues along the data boundary.
  std::optional<glm::dvec3> search_in_data(const glm::dvec3& index, const glm::dvec3& step, double residual,
                                           double guess) {
    const double out = distance_to_boundary(index, step);
    if (const auto distance = search(index, step, residual, guess, kReach, std::min(kReach, out))) {
      return *distance * step;
    }
    if (out >= kReach) return std::nullopt;
    const glm::dvec3 exit_point = glm::clamp(index + out * step, low_, high_);
    glm::dvec3 slide = step;
    for (int axis = 0; axis < 3; ++axis) {
      if (step[axis] > 0 ? exit_point[axis] == high_[axis] : exit_point[axis] == low_[axis]) {
        slide[axis] = 0;
      }
    }
    const double length = glm::length(slide);
    if (!(length > 0)) return std::nullopt;
    slide /= length;
    const double limit = std::min(kReach - out, distance_to_boundary(exit_point, slide));
    const auto distance = search(exit_point, slide, residual, guess, kReach, limit);
    return distance ? std::optional(exit_point + *distance * slide - index) : std::nullopt;
  }

  // Searches toward each cell corner on the other side of the surface, because a crossing lies on the way. Sets
  // `nearest` to a point found if that is nearer.
  void search_to_corners(const glm::dvec3& index, double residual, std::optional<glm::dvec3>& nearest) {
    glm::dvec3 cell = glm::floor(index);
    if (last_cell_) cell = glm::clamp(cell, glm::dvec3(0), glm::dvec3(*last_cell_));
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 way = cell + glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) - index;
      const double length = glm::length(way);
      const double value = field_(index + way).value;
      if (length == 0 || !std::isfinite(value) || (value != 0 && (value > 0) == (residual > 0))) continue;
      const auto distance = search(index, way / length, residual, length, length, length);
      const glm::dvec3 found = way * (distance.value_or(length) / length);
      if (!nearest || glm::length(linear_ * found) < glm::length(linear_ * *nearest)) nearest = found;
    }
  }

  // Returns the distance to the first change of sign from `index` along the unit vector `step`. Tries 1.25 times the
  // guess first, but at most an eighth of `reach`; then goes on in steps of an eighth. Returns nothing if no change is
  // within `limit`, or a sample is not finite.
  std::optional<double> search(const glm::dvec3& index, const glm::dvec3& step, double residual, double guess,
                               double reach, double limit) {
    const auto at = [&](double s) { return field_(index + s * step).value; };
    double near = 0;
    double near_value = residual;
    double far = std::min({1.25 * guess, reach / 8, limit});
    for (;;) {
      const double far_value = at(far);
      if (!std::isfinite(far_value)) return std::nullopt;
      if (far_value == 0 || (far_value > 0) != (residual > 0)) {
        return find_crossing(at, near, near_value, far, far_value, 1e-9 * std::abs(residual));
      }
      if (far >= limit) return std::nullopt;
      near = far;
      near_value = far_value;
      far = std::min(far + reach / 8, limit);
    }
  }

  const field::Interpolant& interpolant_;
  field::Interpolant::Cursor field_;
  glm::dmat3 linear_;
  double shortest_;
  glm::dvec3 width_{0.0};  // cell width between opposite faces, in the mesh's coordinates
  glm::dmat3 metric_;      // maps gradients in index space to index-space steps along the world's gradient
  std::optional<glm::ivec3> last_cell_;  // dense data only; sparse data have no data boundary
  glm::dvec3 low_{-kInfinity};
  glm::dvec3 high_{kInfinity};
};

}  // namespace isoextract::accuracy
