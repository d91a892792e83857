// Finds points of a surface: one near a given point (land), and the foot of a given point (approach), which is the
// surface point nearest to it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <glm/glm.hpp>

#include "accuracy/detail/largest_component.hpp"

namespace isoextract::accuracy {

// `Function` returns `value` and `gradient` at a point in its own coordinates; it may cache.
template <class Function>
class FootFinder {
 public:
  // `linear` maps steps to the coordinates in which distances are measured. The surface ends at `low` and `high`.
  FootFinder(Function function, double iso, const glm::dmat3& linear, const glm::dvec3& low, const glm::dvec3& high)
      : function_(std::move(function)), iso_(iso), linear_(linear), low_(low), high_(high) {
    const glm::dmat3 inverse = glm::inverse(linear);
    metric_ = inverse * glm::transpose(inverse);
  }

  // Returns a point of the surface within `reach` of `start`, by Newton's method along the gradient, or nothing.
  [[nodiscard]] std::optional<glm::dvec3> land(const glm::dvec3& start, double reach) {
    constexpr int kMaxSteps = 12;
    constexpr double kEnough = 1e-9;
    constexpr double kAcceptable = 1e-4;
    glm::dvec3 point = glm::clamp(start, low_, high_);
    double moved = std::numeric_limits<double>::infinity();
    for (int step = 0; step < kMaxSteps && moved > kEnough * reach; ++step) {
      const auto here = function_(point);
      const double residual = here.value - iso_;
      if (residual == 0) return point;
      const double largest = max_abs_component(here.gradient);
      if (!std::isfinite(residual) || !(largest > 0)) return std::nullopt;
      // Scales the gradient first: its square may leave the range of double.
      const glm::dvec3 gradient = here.gradient / largest;
      const glm::dvec3 along = metric_ * gradient;
      const glm::dvec3 next = glm::clamp(point - along * (residual / largest / glm::dot(gradient, along)), low_, high_);
      // If the box shortens a step, the remaining distance counts, too.
      moved = std::max(length(next - point), std::abs(residual / largest) / std::sqrt(glm::dot(gradient, along)));
      point = next;
      if (!(length(point - start) <= reach)) return std::nullopt;
    }
    return moved <= kAcceptable * reach ? std::optional(point) : std::nullopt;
  }

  // Slides from `start` along the surface toward the point nearest to `p`; each step is at most `reach` long. Returns
  // the last point, which is never farther from `p` than `start`.
  [[nodiscard]] glm::dvec3 approach(const glm::dvec3& p, const glm::dvec3& start, double reach) {
    constexpr int kMaxSteps = 8;
    constexpr double kEnough = 0.02;  // fraction of the distance; the error falls with its square
    glm::dvec3 point = start;
    double distance = length(p - point);
    for (int step = 0; step < kMaxSteps; ++step) {
      const glm::dvec3 gradient = function_(point).gradient;
      const double largest = max_abs_component(gradient);
      if (!(largest > 0)) break;
      const glm::dvec3 scaled = gradient / largest;
      const glm::dvec3 along = metric_ * scaled;
      const glm::dvec3 away = p - point;
      glm::dvec3 slide = away - along * (glm::dot(scaled, away) / glm::dot(scaled, along));
      const double way = length(slide);
      if (!(way > kEnough * distance)) break;
      slide *= std::min(1.0, reach / way);
      bool nearer = false;
      for (int halving = 0; halving < 3 && !nearer; ++halving, slide *= 0.5) {
        const auto landed = land(point + slide, reach);
        if (!landed || !(length(p - *landed) < distance)) continue;
        nearer = true;
        point = *landed;
        distance = length(p - point);
      }
      if (!nearer) break;
    }
    return point;
  }

  [[nodiscard]] double length(const glm::dvec3& step) const { return glm::length(linear_ * step); }
  Function& function() { return function_; }

 private:
  Function function_;
  double iso_;
  glm::dmat3 linear_;
  glm::dmat3 metric_;  // maps gradients to steps along the gradient in the coordinates of distances
  glm::dvec3 low_;
  glm::dvec3 high_;
};

}  // namespace isoextract::accuracy
