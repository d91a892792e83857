// A jet of liquid into a tank, as particles: the animation of the paper on marching tetrahedra in shaders, whose
// liquid is a simple particle system in a cube from -30 to 30.
//
// The tank is a closed box around the origin, z up. A round nozzle in the wall of least x, at three quarters of the
// height, emits particles along +x at a steady speed and rate, until the tank holds `count` particles. The fluid is
// position based dynamics (Macklin and Mueller 2013; see detail/fluid.hpp).
//
// Frames are 1 / fps apart and consist of steps. In a step, velocity and gravity move no particle farther than 0.8
// spacings, a spacing being two radii (a Courant-Friedrichs-Lewy condition: a kernel reaches over 2); corrections of
// the density come on top. The top speed is twice the speed of a particle that left the nozzle and fell the tank's
// whole height; faster particles are slowed down and counted.
//
// All numbers are double and bitwise equal for any number of threads. One seed gives the same particles on every
// machine with IEEE arithmetic, if its compiler fuses no operations; the default radius also needs the same std::cbrt.
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
  double speed = 60;             // speed at the nozzle; above 0
  double gravity = 98.1;         // towards -z; 0 or more; 9.81 m/s^2 if the unit is a decimeter
  double fps = 24;               // frames per unit of time; above 0
  double viscosity = 0.05;       // c of XSPH; 0 to 1/2
  int iterations = 4;            // solver iterations per step; 1 to 1000
  std::uint64_t seed = 0;
};

struct JetFigures {
  std::uint64_t frames = 0;
  std::uint64_t steps = 0;
  std::uint64_t particle_steps = 0;  // sum over all steps of the number of particles moved
  std::uint64_t slowed_down = 0;     // how often a particle was slowed to the top speed
};

enum class JetUp {
  z,
  y,  // (x, y, z) of the tank becomes (x, z, -y)
};

class ParticleJet {
 public:
  // Fails with ErrorCode::usage for options that are not finite or out of range, and for a tank too small for nozzle or
  // particles, or wider than 2^20 spacings. Also fails with ErrorCode::usage if a layer of the nozzle has more than
  // `count` (at least 5) particles, or if a frame could take more than kMostSteps steps. Fails as Context::reserve()
  // does if memory is short.
  [[nodiscard]] static Result<ParticleJet> make(const JetOptions& options, const Context& context);

  ParticleJet(ParticleJet&&) noexcept;
  ParticleJet& operator=(ParticleJet&&) noexcept;
  ~ParticleJet();

  // Advances to the next frame; the first one is 1 / fps after the nozzle opens. Fails with ErrorCode::cancelled, or
  // as Context::reserve() does if memory is short; do not use the jet afterwards.
  [[nodiscard]] Result<void> advance(const Context& context);

  // Returns the particles in the tank, in the order in which they left the nozzle. Attributes: `velocity` (3
  // components), `age` (since it left the nozzle), `id` (0 for the first particle). `up` is the up axis of the
  // returned positions and velocities. Fails as Context::reserve() does.
  [[nodiscard]] Result<points::ParticleSet> particles(const Context& context, JetUp up = JetUp::z) const;

  // Returns the particle radius in use: JetOptions::radius or its default.
  [[nodiscard]] double radius() const;
  [[nodiscard]] std::uint64_t size() const;
  [[nodiscard]] JetFigures figures() const;

 private:
  struct State;
  explicit ParticleJet(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::simulate
