// A fluid of particles in a box under gravity: M. Macklin and M. Mueller, "Position based fluids" (ACM TOG 32(4),
// 2013), Algorithm 1. One step
// - moves all particles by their velocities and gravity (lines 1 to 4) and finds their neighbors there (5 to 7);
// - moves particles apart where the density exceeds the rest density (lines 8 to 19): Jacobi iterations of equations 8
//   to 12, with the constraint relaxed as in equation 11;
// - derives velocities from positions (line 21) and evens them out between neighbors (XSPH, equation 17).
//
// The paper's constraint demands the rest density; ours only limits it. Particles at a surface, which have few
// neighbors, are not pulled together, so the artificial pressure of section 4 is not needed. Vorticity confinement is
// left out. Particles too dense at the start of a step are first moved apart without velocity (pre-stabilization: M.
// Macklin, M. Mueller, N. Chentanez, T.-Y. Kim, "Unified particle physics for real-time applications", ACM TOG 33(4),
// 2014, section 4.4). Otherwise they would gain energy; a shorter step would make the gain larger.
//
// Walls add the density behind them (fluid_kernels.hpp). No particle's center comes closer to a wall than half a
// spacing; particles slide along walls. Positions are double, as a velocity is the difference of two positions a short
// step apart. All sums use a fixed order, so results do not depend on the number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "simulate/detail/fluid_kernels.hpp"
#include "simulate/detail/neighbor_lists.hpp"

namespace isoextract::simulate {

struct FluidOptions {
  double spacing = 1;   // distance of particles at rest
  glm::dvec3 low{0.0};  // the box; at least 1 and at most 2^20 spacings wide
  glm::dvec3 high{1.0};
  double gravity = 0;    // towards -z
  double viscosity = 0;  // c of XSPH; 0 to 1/2
  int iterations = 4;
  double top_speed = 1;  // faster particles are slowed to it and counted
};

class Fluid {
 public:
  // Reserves memory for `capacity` particles, below 2^32. Does not check the options. Fails as Context::reserve() does.
  [[nodiscard]] static Result<Fluid> make(const FluidOptions& options, std::size_t capacity, const Context& context);

  // Adds particle number size(); there must be room, and `place` must be at least half a spacing from each wall.
  void add(const glm::dvec3& place, const glm::dvec3& velocity);

  // Advances by `duration`. Fails as Context::reserve() and Context::check() do; the fluid is unusable afterwards.
  [[nodiscard]] Result<void> step(double duration, const Context& context);

  [[nodiscard]] std::size_t size() const { return size_; }
  // Each returns a property of the particles, all in one order, which changes with every step.
  [[nodiscard]] std::span<const glm::dvec3> places() const { return places_.span().first(size_); }
  [[nodiscard]] std::span<const glm::dvec3> velocities() const { return velocities_.span().first(size_); }
  [[nodiscard]] std::span<const std::uint32_t> numbers() const { return numbers_.span().first(size_); }

  [[nodiscard]] double fastest() const;
  // Returns the kinetic energy plus the potential energy above the floor (low.z); a particle has mass 1.
  [[nodiscard]] double energy() const;
  [[nodiscard]] std::uint64_t slowed_down() const { return slowed_down_; }  // so far

 private:
  explicit Fluid(const FluidOptions& options);

  struct Wall {
    double share = 0;  // fraction of the rest density
    glm::dvec3 gradient{0.0};
  };
  [[nodiscard]] Wall wall_density(const glm::dvec3& place) const;
  void predict(double duration);
  [[nodiscard]] Result<void> sort_by_cells(const Context& context);
  [[nodiscard]] double density_at(std::size_t i, const Buffer<glm::dvec3>& places) const;
  bool find_multipliers(const Buffer<glm::dvec3>& places);
  void find_corrections(const Buffer<glm::dvec3>& places);
  void stabilize();
  void update_velocities(double duration);
  void apply_viscosity();

  FluidOptions options_;
  FluidKernels kernels_;
  glm::dvec3 least_;  // limits of particle centers
  glm::dvec3 most_;
  std::size_t size_ = 0;
  std::uint64_t slowed_down_ = 0;
  Buffer<glm::dvec3> places_;
  Buffer<glm::dvec3> velocities_;
  Buffer<glm::dvec3> moved_;  // x* of the paper
  Buffer<glm::dvec3> scratch_;
  Buffer<double> multipliers_;  // lambda; later the densities for XSPH
  Buffer<std::uint32_t> numbers_;
  Buffer<std::uint32_t> number_scratch_;
  NeighborLists neighbors_;
  Reservation memory_;
};

}  // namespace isoextract::simulate
