// A jet of liquid into a tank, as particles: the animation of the seed paper on marching tetrahedra in shaders, whose
// liquid is a simple particle system in a cube from -30 to 30.
//
// The tank is a closed box around the origin, z up. A round nozzle in the wall of least x, at three quarters of the
// height, emits particles along +x at a steady speed and rate, until the tank holds `count` particles. The fluid is
// position based dynamics (Macklin and Mueller 2013; see detail/fluid.hpp).
//
// Frames are 1 / fps apart and consist of steps. In a step no particle moves farther than 0.8 spacings, gravity
// included (a Courant-Friedrichs-Lewy condition: a kernel reaches over 2). The top speed is twice what the fastest
// particle would have after falling from the nozzle through the whole tank; faster particles are slowed down and
// counted.
//
// All numbers are double and bitwise equal for any number of threads. One seed gives the same particles on every
// machine with IEEE arithmetic, if its compiler fuses no operations.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "points/particle_set.hpp"

namespace isoextract::simulate {

// The caller chooses the units of length and time. Particles at rest are two radii apart.
struct JetOptions {
  // Files store particle numbers as float32.
  static constexpr std::uint64_t kMaxParticles = std::uint64_t{1} << 24;
  static constexpr double kMostSteps = 10000;  // per frame

  std::uint64_t count = 20000;  // 1 to kMaxParticles
  // Particle radius. Default: all particles together fill a tenth of the tank, but the radius is at most half the
  // nozzle's.
  std::optional<double> radius;
  glm::dvec3 tank{60.0};         // lengths of its sides
  std::optional<double> nozzle;  // radius; default: a twelfth of the smaller of the tank's y and z sides
  double speed = 60;             // speed at the nozzle
  double gravity = 98.1;         // towards -z; 9.81 m/s^2 if the unit is a decimeter
  double fps = 24;               // frames per second
  double viscosity = 0.05;       // c of XSPH; 0 to 1/2
  int iterations = 4;            // solver iterations per step; 1 to 1000
  std::uint64_t seed = 0;
};

struct JetFigures {
  std::uint64_t frames = 0;
  std::uint64_t steps = 0;
  std::uint64_t particle_steps = 0;  // sum over all steps of the number of particles
  std::uint64_t slowed_down = 0;     // how often a particle was slowed to the top speed
};

class ParticleJet {
 public:
  // Fails with ErrorCode::usage for options that are not finite or out of range, and for a tank too small for nozzle or
  // particles. Fails likewise for a tank wider than 2^20 spacings, or if a frame would take more than kMostSteps steps.
  // Fails with ErrorCode::out_of_memory if memory is short.
  [[nodiscard]] static Result<ParticleJet> make(const JetOptions& options, const Context& context);

  ParticleJet(ParticleJet&&) noexcept;
  ParticleJet& operator=(ParticleJet&&) noexcept;
  ~ParticleJet();

  // Advances to the next frame; the first one is 1 / fps after the nozzle opens. Fails with ErrorCode::cancelled, or
  // with ErrorCode::out_of_memory if memory is short.
  [[nodiscard]] Result<void> advance(const Context& context);

  // Returns the particles in the tank, in the order in which they came. Attributes: `velocity` (3 components), `age`
  // (time since leaving the nozzle), `id` (0 for the first particle). Fails as Context::reserve() does.
  [[nodiscard]] Result<points::ParticleSet> particles(const Context& context) const;

  // Returns the radius of a particle that is in use.
  [[nodiscard]] double radius() const;
  [[nodiscard]] std::uint64_t size() const;
  [[nodiscard]] JetFigures figures() const;

 private:
  struct State;
  explicit ParticleJet(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::simulate
