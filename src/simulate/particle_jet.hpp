// A jet of liquid into a tank, as particles: the animation of the seed paper on marching tetrahedra in shaders, whose
// liquid is a simple system of particles in a cube from -30 to 30.
//
// The tank is a closed box around the origin, z up. A round nozzle in the wall at its least x, three quarters up, lets
// particles in along +x at a steady speed and rate until the tank holds as many as it is to. They are a fluid of
// position based dynamics (Macklin and Mueller 2013; detail/fluid.hpp says what of it).
//
// Frames are 1 / fps apart, in steps: in a step no particle moves farther than 0.8 spacings, gravity included (a
// condition of Courant, Friedrichs and Lewy: a kernel reaches over 2). No particle gets faster than twice the speed
// that the fastest at the nozzle would have after falling through the whole tank; what tries to is slowed down and
// counted.
//
// All is double, and the same bit by bit for any number of threads. Particles of one seed are the same on every machine
// with IEEE arithmetic, as far as its compiler fuses nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "points/particle_set.hpp"

namespace isoextract::simulate {

// Lengths and times are in units of the caller's choice; particles are two radii apart at rest.
struct JetOptions {
  // Numbers of particles are float32 in files.
  static constexpr std::uint64_t kMostParticles = std::uint64_t{1} << 24;
  static constexpr double kMostSteps = 10000;  // a frame

  std::uint64_t count = 20000;   // 1 to kMostParticles
  std::optional<double> radius;  // of a particle; else so that all of them fill a tenth of the tank, or the nozzle
  glm::dvec3 tank{60.0};         // its sides
  std::optional<double> nozzle;  // its radius; else a twelfth of the shorter of the tank's width and height
  double speed = 60;             // of what leaves it
  double gravity = 98.1;         // 9.81 m/s^2 where a unit is a decimetre
  double fps = 24;               // frames a second
  double viscosity = 0.05;       // 0 to 1/2: c of XSPH
  int iterations = 4;            // of the solver in a step, 1 to 1000
  std::uint64_t seed = 0;
};

struct JetFigures {
  std::uint64_t frames = 0;
  std::uint64_t steps = 0;
  std::uint64_t particle_steps = 0;  // particles, each as many times as it was moved
  std::uint64_t slowed_down = 0;     // how often a particle was
};

class ParticleJet {
 public:
  // Fails with ErrorCode::usage where a number is not finite or outside of what is said above, where the tank is too
  // small for the nozzle or for the particles, where it is more than 2^20 spacings wide, or where a frame would take
  // more than kMostSteps steps. With ErrorCode::input where the memory is not there.
  [[nodiscard]] static Result<ParticleJet> make(const JetOptions& options, const Context& context);

  ParticleJet(ParticleJet&&) noexcept;
  ParticleJet& operator=(ParticleJet&&) noexcept;
  ~ParticleJet();

  // To the next frame; the first is 1 / fps after the nozzle was opened. Fails with ErrorCode::cancelled, and with
  // ErrorCode::input where the memory is not there.
  [[nodiscard]] Result<void> advance(const Context& context);

  // Those that are in the tank now, in the order in which they came, with the attributes `velocity` (3), `age` (since
  // they left the nozzle) and `id` (0 for the first). Fails as Context::reserve() does.
  [[nodiscard]] Result<points::ParticleSet> particles(const Context& context) const;

  // Of a particle, in use.
  [[nodiscard]] double radius() const;
  [[nodiscard]] std::uint64_t size() const;
  [[nodiscard]] JetFigures figures() const;

 private:
  struct State;
  explicit ParticleJet(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::simulate
