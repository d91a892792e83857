// Kernels of a particle fluid, relative to the rest density: poly6 for densities, spiky for gradients. See M. Mueller,
// D. Charypar, M. Gross, "Particle-based fluid simulation for interactive applications" (SCA 2003), section 3.5, and M.
// Macklin, M. Mueller, "Position based fluids" (ACM TOG 32(4), 2013), section 3.
//
// At rest, particles form a cubic lattice. A kernel reaches over two spacings. The rest density is the sum of poly6
// over the lattice; here it is 1 for any spacing.
//
// A flat wall replaces the particles behind it by the part of the kernel's integral that lies there.
#pragma once

#include <cmath>

#include <glm/glm.hpp>

namespace isoextract::simulate {

namespace detail {

inline constexpr double kKernelReach = 2;  // spacings

// Returns the sum of poly6 over the lattice, in units of poly6 at 0.
constexpr double lattice_sum() {
  double sum = 0;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      for (int z = -2; z <= 2; ++z) {
        const double t = 1 - (x * x + y * y + z * z) / (kKernelReach * kKernelReach);
        if (t > 0) sum += t * t * t;
      }
    }
  }
  return sum;
}

}  // namespace detail

// Distances are in world units, densities in rest densities, gradients in rest densities per world unit.
class FluidKernels {
 public:
  explicit FluidKernels(double spacing) : reach_(detail::kKernelReach * spacing), reach2_(reach_ * reach_) {}

  [[nodiscard]] double reach() const { return reach_; }
  [[nodiscard]] double reach2() const { return reach2_; }

  // Returns the density that a particle adds at a squared distance below reach2().
  [[nodiscard]] double density(double distance2) const {
    const double t = 1 - distance2 / reach2_;
    return t * t * t / kRest;
  }
  static constexpr double own_density() { return 1 / kRest; }

  // Returns the gradient by p of the density that a particle at q adds at p; d is p - q, shorter than reach(). Returns
  // 0 if p and q are equal.
  [[nodiscard]] glm::dvec3 gradient(const glm::dvec3& d, double distance2) const {
    const double distance = std::sqrt(distance2);
    if (!(distance > 0)) return glm::dvec3(0);
    const double t = 1 - distance / reach_;
    return d * (-kSpikyToPoly6 / kRest * t * t / (reach_ * distance));
  }

  // Returns the density that a wall adds at a distance from 0 to reach(): 1/2 at 0.
  [[nodiscard]] double wall(double distance) const {
    const double u = distance / reach_;
    const double u2 = u * u;
    // 315/256 times the integral of (1 - z^2)^4 from u to 1.
    const double within = u * (1 + u2 * (-4.0 / 3 + u2 * (6.0 / 5 + u2 * (-4.0 / 7 + u2 / 9))));
    return 0.5 - 315.0 / 256 * within;
  }
  // Returns the derivative of the spiky kernel's wall density by distance: minus the kernel's integral over the plane.
  [[nodiscard]] double wall_slope(double distance) const {
    const double a = 1 - distance / reach_;
    const double a4 = a * a * a * a;
    return -30 * a4 * (0.25 - a / 5) / reach_;
  }

 private:
  static constexpr double kRest = detail::lattice_sum();
  // Ratio of the kernels' factors: 45 / (pi h^4) divided by 315 / (64 pi h^3), times h.
  static constexpr double kSpikyToPoly6 = 64.0 / 7;

  double reach_;
  double reach2_;
};

}  // namespace isoextract::simulate
