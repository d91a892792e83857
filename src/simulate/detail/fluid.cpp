#include "simulate/detail/fluid.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "base/parallel.hpp"

namespace isoextract::simulate {
namespace {

constexpr std::size_t kGrain = 256;  // particles

// Epsilon of equation 11 times the squared spacing. Inside a fluid, the sum that it is added to is about 0.4.
constexpr double kRelaxation = 0.1;

template <class F>
void for_each_particle(std::size_t count, const F& f) {
  for_each_index(count, f, kGrain);
}

}  // namespace

Fluid::Fluid(const FluidOptions& options)
    : options_(options),
      kernels_(options.spacing),
      least_(options.low + options.spacing / 2),
      most_(options.high - options.spacing / 2) {}

Result<Fluid> Fluid::make(const FluidOptions& options, std::size_t capacity, const Context& context) {
  constexpr std::size_t kBytes = 4 * sizeof(glm::dvec3) + sizeof(double) + 2 * sizeof(std::uint32_t);
  auto memory =
      TRY(context.reserve(std::uint64_t{capacity} * kBytes, fmt::format("a fluid of {} particles", capacity)));
  Fluid fluid(options);
  fluid.memory_ = std::move(memory);
  fluid.places_ = Buffer<glm::dvec3>(capacity);
  fluid.velocities_ = Buffer<glm::dvec3>(capacity);
  fluid.moved_ = Buffer<glm::dvec3>(capacity);
  fluid.scratch_ = Buffer<glm::dvec3>(capacity);
  fluid.multipliers_ = Buffer<double>(capacity);
  fluid.numbers_ = Buffer<std::uint32_t>(capacity);
  fluid.number_scratch_ = Buffer<std::uint32_t>(capacity);
  return fluid;
}

void Fluid::add(const glm::dvec3& place, const glm::dvec3& velocity) {
  places_[size_] = place;
  velocities_[size_] = velocity;
  numbers_[size_] = static_cast<std::uint32_t>(size_);
  ++size_;
}

Result<void> Fluid::step(double duration, const Context& context) {
  TRY(context.check());
  if (size_ == 0) return {};
  predict(duration);
  TRY(sort_by_cells(context));
  stabilize();
  for (int i = 0; i < options_.iterations && find_multipliers(moved_); ++i) {
    find_corrections(moved_);
    for_each_particle(size_, [&](std::size_t k) { moved_[k] = glm::clamp(moved_[k] + scratch_[k], least_, most_); });
  }
  update_velocities(duration);
  if (options_.viscosity > 0) apply_viscosity();
  return {};
}

double Fluid::fastest() const {
  const auto most = [&](std::size_t begin, std::size_t end, double speed2) {
    for (std::size_t i = begin; i != end; ++i) {
      speed2 = std::max(speed2, glm::dot(velocities_[i], velocities_[i]));
    }
    return speed2;
  };
  return std::sqrt(reduce_ranges(size_, kGrain, 0.0, most, [](double a, double b) { return std::max(a, b); }));
}

double Fluid::energy() const {
  double sum = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    sum += glm::dot(velocities_[i], velocities_[i]) / 2 + options_.gravity * (places_[i].z - options_.low.z);
  }
  return sum;
}

void Fluid::predict(double duration) {
  const glm::dvec3 fall(0, 0, -options_.gravity * duration);
  for_each_particle(size_, [&](std::size_t i) {
    moved_[i] = glm::clamp(places_[i] + duration * (velocities_[i] + fall), least_, most_);
  });
}

// Particles near in space become near in memory. Velocities are not sorted, as they are computed anew.
Result<void> Fluid::sort_by_cells(const Context& context) {
  const auto grid =
      TRY(points::CellGrid::make(moved_.span().first(size_), {.origin = options_.low, .unit = 1}, kernels_.reach(),
                                 points::CellGrid::Coinciding::apart, context, "a fluid"));
  const auto member = [&](std::size_t spot) { return grid.members(spot).front(); };
  for_each_particle(size_, [&](std::size_t i) {
    scratch_[i] = moved_[member(i)];
    velocities_[i] = places_[member(i)];
    number_scratch_[i] = numbers_[member(i)];
  });
  std::swap(moved_, scratch_);
  std::swap(places_, velocities_);
  std::swap(numbers_, number_scratch_);
  return neighbors_.make(grid, moved_.span().first(size_), kernels_.reach(), context);
}

// Combines the walls of the box as if each were a half-space. The product is exact if two walls are far apart, and
// nearly so in edges and corners.
Fluid::Wall Fluid::wall_density(const glm::dvec3& place) const {
  double left = 1;  // the kernel's part inside the box
  glm::dvec3 logarithmic(0);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      const double distance = side > 0 ? place[axis] - options_.low[axis] : options_.high[axis] - place[axis];
      if (distance >= kernels_.reach()) continue;
      const double inside = 1 - kernels_.wall(distance);
      left *= inside;
      logarithmic[axis] += side * kernels_.wall_slope(distance) / inside;
    }
  }
  return {1 - left, left * logarithmic};
}

// Returns the density relative to rest, from the particles that were neighbors at the start of the step.
double Fluid::density_at(std::size_t i, const Buffer<glm::dvec3>& places) const {
  double density = FluidKernels::own_density();
  for (const std::uint32_t j : neighbors_.of(i)) {
    const glm::dvec3 d = places[i] - places[j];
    const double distance2 = glm::dot(d, d);
    if (distance2 < kernels_.reach2()) density += kernels_.density(distance2);
  }
  return density;
}

// Equation 11. Returns false if no density exceeds the rest density.
bool Fluid::find_multipliers(const Buffer<glm::dvec3>& places) {
  const double relaxation = kRelaxation / (options_.spacing * options_.spacing);
  const auto find = [&](std::size_t i) {
    const glm::dvec3 place = places[i];
    const Wall wall = wall_density(place);
    const double density = density_at(i, places) + wall.share;
    if (!(density > 1)) return 0.0;
    glm::dvec3 own = wall.gradient;
    double squares = relaxation;
    for (const std::uint32_t j : neighbors_.of(i)) {
      const glm::dvec3 d = place - places[j];
      const double distance2 = glm::dot(d, d);
      if (distance2 >= kernels_.reach2()) continue;
      const glm::dvec3 gradient = kernels_.gradient(d, distance2);
      own += gradient;
      squares += glm::dot(gradient, gradient);
    }
    return (1 - density) / (squares + glm::dot(own, own));
  };
  return reduce_ranges(
      size_, kGrain, false,
      [&](std::size_t begin, std::size_t end, bool any) {
        for (std::size_t i = begin; i != end; ++i) {
          multipliers_[i] = find(i);
          any = any || multipliers_[i] != 0;
        }
        return any;
      },
      std::logical_or<>());
}

// Equation 12; the result is in scratch_.
void Fluid::find_corrections(const Buffer<glm::dvec3>& places) {
  for_each_particle(size_, [&](std::size_t i) {
    const double own = multipliers_[i];
    glm::dvec3 correction(0);
    for (const std::uint32_t j : neighbors_.of(i)) {
      const double both = own + multipliers_[j];
      if (both == 0) continue;
      const glm::dvec3 d = places[i] - places[j];
      const double distance2 = glm::dot(d, d);
      if (distance2 < kernels_.reach2()) correction += both * kernels_.gradient(d, distance2);
    }
    if (own != 0) correction += own * wall_density(places[i]).gradient;
    scratch_[i] = correction;
  });
}

// Moves particles apart where the density is too high. Moves places before and after the step equally, so that the
// particles gain no velocity.
void Fluid::stabilize() {
  if (!find_multipliers(places_)) return;
  find_corrections(places_);
  for_each_particle(size_, [&](std::size_t i) {
    places_[i] = glm::clamp(places_[i] + scratch_[i], least_, most_);
    moved_[i] = glm::clamp(moved_[i] + scratch_[i], least_, most_);
  });
}

void Fluid::update_velocities(double duration) {
  const double top2 = options_.top_speed * options_.top_speed;
  slowed_down_ += reduce_ranges(
      size_, kGrain, std::uint64_t{0},
      [&](std::size_t begin, std::size_t end, std::uint64_t slowed) {
        for (std::size_t i = begin; i != end; ++i) {
          velocities_[i] = (moved_[i] - places_[i]) / duration;
          const double speed2 = glm::dot(velocities_[i], velocities_[i]);
          if (speed2 > top2) {
            velocities_[i] *= options_.top_speed / std::sqrt(speed2);
            moved_[i] = glm::clamp(places_[i] + duration * velocities_[i], least_, most_);
            ++slowed;
          }
        }
        return slowed;
      },
      std::plus<>());
  std::swap(places_, moved_);
}

// Equation 17, divided by the larger of both densities if that exceeds the rest density. Each new velocity is then a
// weighted mean of old ones, so none exceeds the fastest.
void Fluid::apply_viscosity() {
  for_each_particle(size_, [&](std::size_t i) { multipliers_[i] = std::max(density_at(i, places_), 1.0); });
  for_each_particle(size_, [&](std::size_t i) {
    glm::dvec3 change(0);
    for (const std::uint32_t j : neighbors_.of(i)) {
      const glm::dvec3 d = places_[i] - places_[j];
      const double distance2 = glm::dot(d, d);
      if (distance2 >= kernels_.reach2()) continue;
      const double weight = kernels_.density(distance2) / std::max(multipliers_[i], multipliers_[j]);
      change += weight * (velocities_[j] - velocities_[i]);
    }
    scratch_[i] = velocities_[i] + options_.viscosity * change;
  });
  std::swap(velocities_, scratch_);
}

}  // namespace isoextract::simulate
