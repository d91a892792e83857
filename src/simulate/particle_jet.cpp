#include "simulate/particle_jet.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/parallel.hpp"
#include "simulate/detail/fluid.hpp"
#include "simulate/detail/nozzle.hpp"

namespace isoextract::simulate {
namespace {

constexpr double kFillFraction = 0.1;     // fraction of the tank that all particles fill
constexpr double kMinFreeFraction = 0.1;  // fraction of the tank that stays empty
constexpr double kCourant = 0.8;          // largest move in a step, in spacings
constexpr double kMostSpacings = 1 << 20;
constexpr std::uint64_t kLeastLayer =
    5;                            // particles in a layer of a nozzle one spacing in radius, the smallest default
constexpr double kHeight = 0.75;  // height of the nozzle, as a fraction of the tank's

Result<void> check_positive(double value, std::string_view what) {
  if (std::isfinite(value) && value > 0) return {};
  return fail(ErrorCode::usage, fmt::format("expected {} above 0, found {}", what, value));
}

Result<void> check_range(double value, double low, double high, std::string_view what) {
  if (value >= low && value <= high) return {};
  return fail(ErrorCode::usage, fmt::format("expected {} from {} to {}, found {}", what, low, high, value));
}

Result<void> check_numbers(const JetOptions& o) {
  if (o.count < 1 || o.count > JetOptions::kMaxParticles) {
    return fail(ErrorCode::usage,
                fmt::format("expected 1 to {} particles, found {}", JetOptions::kMaxParticles, o.count));
  }
  for (int axis = 0; axis < 3; ++axis) {
    TRY(check_positive(o.tank[axis], "a side of the tank"));
  }
  if (o.radius) {
    TRY(check_positive(*o.radius, "a radius of particles"));
  }
  if (o.nozzle) {
    TRY(check_positive(*o.nozzle, "a radius of the nozzle"));
  }
  TRY(check_positive(o.speed, "a speed"));
  TRY(check_positive(o.fps, "a number of frames a second"));
  if (!std::isfinite(o.gravity) || o.gravity < 0) {
    return fail(ErrorCode::usage, fmt::format("expected a gravity of 0 or more, found {}", o.gravity));
  }
  TRY(check_range(o.viscosity, 0, 0.5, "a viscosity"));
  return check_range(o.iterations, 1, 1000, "a number of iterations");
}

// Returns the longest step in which a particle of this speed, accelerated by gravity, moves at most `most`: the t of v
// t + g t^2 = most, written so that nothing cancels.
double longest_step(double speed, double gravity, double most) {
  return 2 * most / (speed + std::sqrt(speed * speed + 4 * gravity * most));
}

struct JetPlan {
  double spacing = 0;
  double nozzle = 0;
  double top_speed = 0;
};

// Estimates the number of particles in a layer of the nozzle.
double layer_estimate(const JetPlan& plan) {
  const double rows = plan.nozzle / plan.spacing;
  return std::numbers::pi * rows * rows;
}

Result<void> check_sizes(const JetOptions& o, const JetPlan& plan) {
  const double widest = std::max({o.tank.x, o.tank.y, o.tank.z});
  if (!(widest <= kMostSpacings * plan.spacing)) {
    return fail(ErrorCode::usage,
                fmt::format("expected a particle radius of at least {:.3g} for a tank with a side of {}, found {}",
                            widest / kMostSpacings / 2, widest, plan.spacing / 2),
                "use larger particles or a smaller tank");
  }
  // Each wall needs half a spacing, plus the jitter at the nozzle.
  const double around = plan.spacing * (0.5 + Nozzle::kJitter);
  if (plan.nozzle + around > std::min(o.tank.y / 2, (1 - kHeight) * o.tank.z) || 2 * around > o.tank.x) {
    return fail(ErrorCode::usage,
                fmt::format("a tank of {} x {} x {} is too small for a nozzle of radius {} and particles of radius {}",
                            o.tank.x, o.tank.y, o.tank.z, plan.nozzle, plan.spacing / 2),
                "use a smaller nozzle, smaller particles or a larger tank; the nozzle is at three quarters of the "
                "tank's height");
  }
  const double cube = plan.spacing * plan.spacing * plan.spacing;
  const double most = (1 - kMinFreeFraction) * o.tank.x * o.tank.y * o.tank.z / cube;
  if (!(static_cast<double>(o.count) <= most)) {
    return fail(ErrorCode::usage,
                fmt::format("expected at most {:.0f} particles of radius {} in a tank of {} x {} x {}, found {}",
                            std::floor(most), plan.spacing / 2, o.tank.x, o.tank.y, o.tank.z, o.count),
                "use fewer or smaller particles, or a larger tank");
  }
  const double layer = layer_estimate(plan);
  const std::uint64_t most_at_once = std::max<std::uint64_t>(o.count, kLeastLayer);
  if (!(layer <= static_cast<double>(most_at_once))) {
    return fail(
        ErrorCode::usage,
        fmt::format(
            "a nozzle of radius {} adds about {:.0f} particles of radius {} at once; expected at most {}, for a "
            "simulation of {} particles",
            plan.nozzle, layer, plan.spacing / 2, most_at_once, o.count),
        "use a smaller nozzle or larger particles");
  }
  const double steps = 1 / (o.fps * longest_step(plan.top_speed, o.gravity, kCourant * plan.spacing));
  if (!(steps <= JetOptions::kMostSteps)) {
    return fail(
        ErrorCode::usage,
        fmt::format("a frame can need {:.0f} steps; the limit is {:.0f} steps (a step moves a particle by at most {} "
                    "particle spacings)",
                    std::ceil(steps), JetOptions::kMostSteps, kCourant),
        "use more frames a second, larger particles, less speed or less gravity");
  }
  return {};
}

Result<JetPlan> plan_jet(const JetOptions& o) {
  TRY(check_numbers(o));
  JetPlan plan;
  plan.nozzle = o.nozzle.value_or(std::min(o.tank.y, o.tank.z) / 12);
  plan.spacing =
      o.radius ? 2 * *o.radius
               : std::min(std::cbrt(kFillFraction * o.tank.x * o.tank.y * o.tank.z / static_cast<double>(o.count)),
                          plan.nozzle);
  plan.top_speed = 2 * std::sqrt(o.speed * o.speed + 2 * o.gravity * o.tank.z);
  TRY(check_sizes(o, plan));
  return plan;
}

NozzleOptions nozzle_of(const JetOptions& o, const JetPlan& plan) {
  return {.spacing = plan.spacing,
          .radius = plan.nozzle,
          .middle = {-o.tank.x / 2 + (0.5 + Nozzle::kJitter) * plan.spacing, 0, (kHeight - 0.5) * o.tank.z},
          .speed = o.speed,
          .gravity = o.gravity,
          .seed = o.seed};
}

FluidOptions fluid_of(const JetOptions& o, const JetPlan& plan) {
  return {.spacing = plan.spacing,
          .low = -o.tank / 2.0,
          .high = o.tank / 2.0,
          .gravity = o.gravity,
          .viscosity = o.viscosity,
          .iterations = o.iterations,
          .top_speed = plan.top_speed};
}

}  // namespace

struct ParticleJet::State {
  JetOptions options;
  JetPlan plan;
  Reservation nozzle_memory;
  Nozzle nozzle;
  Fluid fluid;
  JetFigures figures;
};

ParticleJet::ParticleJet(std::unique_ptr<State> state) : state_(std::move(state)) {}
ParticleJet::ParticleJet(ParticleJet&&) noexcept = default;
ParticleJet& ParticleJet::operator=(ParticleJet&&) noexcept = default;
ParticleJet::~ParticleJet() = default;

Result<ParticleJet> ParticleJet::make(const JetOptions& options, const Context& context) {
  const auto plan = TRY(plan_jet(options));
  auto fluid = TRY(Fluid::make(fluid_of(options, plan), options.count, context));
  auto memory = TRY(context.reserve(Nozzle::bytes(nozzle_of(options, plan)), "the nozzle of a jet"));
  return ParticleJet(std::make_unique<State>(
      State{options, plan, std::move(memory), Nozzle(nozzle_of(options, plan)), std::move(fluid), {}}));
}

Result<void> ParticleJet::advance(const Context& context) {
  State& s = *state_;
  const double from = static_cast<double>(s.figures.frames) / s.options.fps;
  const double to = static_cast<double>(s.figures.frames + 1) / s.options.fps;
  for (double time = from; time < to;) {
    const double fastest = std::max(s.fluid.fastest(), s.fluid.size() < s.options.count ? s.options.speed : 0.0);
    const double most = longest_step(fastest, s.options.gravity, kCourant * s.plan.spacing);
    const double steps = std::ceil((to - time) / most);
    const double next = steps > 1 ? time + (to - time) / steps : to;
    TRY(s.fluid.step(next - time, context));
    s.figures.particle_steps += s.fluid.size();
    ++s.figures.steps;
    s.nozzle.emit(next, s.options.count - s.fluid.size(),
                  [&](const glm::dvec3& place, const glm::dvec3& velocity) { s.fluid.add(place, velocity); });
    time = next;
  }
  s.figures.slowed_down = s.fluid.slowed_down();
  ++s.figures.frames;
  return {};
}

Result<points::ParticleSet> ParticleJet::particles(const Context& context, JetUp up) const {
  const auto turned = [up](const glm::dvec3& v) {
    return up == JetUp::y ? glm::dvec3(v.x, v.z, 0 - v.y) : v;  // 0 - 0 is 0; -0.0 would be written as -0
  };
  const State& s = *state_;
  const std::size_t count = s.fluid.size();
  const std::string label = fmt::format("frame {} of the jet", s.figures.frames);
  auto memory = TRY(context.reserve(std::uint64_t{count} * (sizeof(glm::dvec3) + 5 * sizeof(float)),
                                    fmt::format("{}: {} particles", label, count)));
  points::ParticleSet set{
      .label = label, .positions = Buffer<glm::dvec3>(count), .attributes = {}, .memory = std::move(memory)};
  set.attributes.push_back({"velocity", 3, Buffer<float>(3 * count)});
  set.attributes.push_back({"age", 1, Buffer<float>(count)});
  set.attributes.push_back({"id", 1, Buffer<float>(count)});
  const double now = static_cast<double>(s.figures.frames) / s.options.fps;
  for_each_range(count, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      const std::uint32_t number = s.fluid.numbers()[i];
      set.positions[number] = turned(s.fluid.places()[i]);
      const glm::dvec3 velocity = turned(s.fluid.velocities()[i]);
      for (int axis = 0; axis < 3; ++axis) {
        set.attributes[0].values[3 * number + static_cast<std::size_t>(axis)] = static_cast<float>(velocity[axis]);
      }
      set.attributes[1].values[number] = static_cast<float>(now - s.nozzle.emission_time(number));
      set.attributes[2].values[number] = static_cast<float>(number);
    }
  });
  return set;
}

double ParticleJet::radius() const { return state_->plan.spacing / 2; }
std::uint64_t ParticleJet::size() const { return state_->fluid.size(); }
JetFigures ParticleJet::figures() const { return state_->figures; }

}  // namespace isoextract::simulate
