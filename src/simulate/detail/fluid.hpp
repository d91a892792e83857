// A fluid of particles in a box under gravity, step by step: M. Macklin and M. Mueller, "Position based fluids" (ACM
// TOG 32(4), 2013), Algorithm 1. One step
//   moves all particles by their velocities, with gravity (lines 1 to 4), and finds their neighbours there (5 to 7);
//   corrects places so that no density is above that at rest (lines 8 to 19): Jacobi iterations of equations 8 to 12,
//     with the constraint relaxed as in equation 11;
//   takes velocities from places (line 21), and evens them out between neighbours (XSPH, equation 17).
//
// Where the paper's constraint asks for the density at rest, ours refuses more than that: particles at a surface, which
// have few neighbours, are not drawn together. So the artificial pressure of section 4 has nothing to prevent;
// vorticity confinement is left out. What is too dense when a step begins is moved apart first, without velocity
// (pre-stabilisation: M. Macklin, M. Mueller, N. Chentanez, T.-Y. Kim, "Unified particle physics for real-time
// applications", ACM TOG 33(4), 2014, section 4.4); else energy would come of it, the more the shorter the step. Walls
// add what is behind them to the density (fluid_kernels.hpp), and no particle's centre gets nearer to one than half a
// spacing; along them it slides.
//
// Places are double: a velocity is a difference of two places that are a short step apart. All sums are taken in one
// order, so every number is the same for any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "simulate/detail/fluid_kernels.hpp"
#include "simulate/detail/neighbour_lists.hpp"

namespace isoextract::simulate {

struct FluidOptions {
  double spacing = 1;   // of particles at rest
  glm::dvec3 low{0.0};  // the box, at least one spacing wide and 2^20 at most
  glm::dvec3 high{1.0};
  double gravity = 0;    // towards -z
  double viscosity = 0;  // c of XSPH, 0 to 1/2
  int iterations = 4;
  double top_speed = 1;  // faster ones are slowed down to it, and counted
};

class Fluid {
 public:
  // Reserves the memory of `capacity` particles, below 2^32.
  [[nodiscard]] static Result<Fluid> make(const FluidOptions& options, std::size_t capacity, const Context& context);

  // One particle more, of those that there is room for; `place` is inside of what particles may reach. It is number
  // size() of all, counted from 0.
  void add(const glm::dvec3& place, const glm::dvec3& velocity);

  // Fails as Context::reserve() and Context::check() do; the fluid is of no use then.
  [[nodiscard]] Result<void> step(double duration, const Context& context);

  [[nodiscard]] std::size_t size() const { return size_; }
  // In an order of their own, which changes with every step.
  [[nodiscard]] std::span<const glm::dvec3> places() const { return places_.span().first(size_); }
  [[nodiscard]] std::span<const glm::dvec3> velocities() const { return velocities_.span().first(size_); }
  [[nodiscard]] std::span<const std::uint32_t> numbers() const { return numbers_.span().first(size_); }

  [[nodiscard]] double fastest() const;
  // Kinetic, and by height over the floor; a particle has mass 1.
  [[nodiscard]] double energy() const;
  [[nodiscard]] std::uint64_t slowed_down() const { return slowed_down_; }  // so far

 private:
  explicit Fluid(const FluidOptions& options);

  struct Wall {
    double share = 0;  // of the density at rest
    glm::dvec3 gradient{0.0};
  };
  [[nodiscard]] Wall wall_at(const glm::dvec3& place) const;
  void predict(double duration);
  [[nodiscard]] Result<void> sort_by_cells(const Context& context);
  [[nodiscard]] double density_at(std::size_t i, const Buffer<glm::dvec3>& places) const;
  bool find_multipliers(const Buffer<glm::dvec3>& places);
  void find_corrections(const Buffer<glm::dvec3>& places);
  void stabilise();
  void update_velocities(double duration);
  void even_out_velocities();

  FluidOptions options_;
  FluidKernels kernels_;
  glm::dvec3 least_;  // of centres
  glm::dvec3 most_;
  std::size_t size_ = 0;
  std::uint64_t slowed_down_ = 0;
  Buffer<glm::dvec3> places_;
  Buffer<glm::dvec3> velocities_;
  Buffer<glm::dvec3> moved_;  // x* of the paper
  Buffer<glm::dvec3> scratch_;
  Buffer<double> multipliers_;  // lambda; densities while velocities are evened out
  Buffer<std::uint32_t> numbers_;
  Buffer<std::uint32_t> number_scratch_;
  NeighbourLists neighbours_;
  Reservation memory_;
};

}  // namespace isoextract::simulate
