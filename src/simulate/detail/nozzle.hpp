// A round nozzle in a wall that emits particles layer by layer. A layer is a square lattice across the nozzle.
// Neighbors in a layer, and consecutive layers, are one spacing apart. A small jitter, from seed and particle number,
// moves each particle off the lattice.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::simulate {

struct NozzleOptions {
  double spacing = 1;
  double radius = 1;       // largest distance of particle centers from the axis, before the jitter
  glm::dvec3 middle{0.0};  // the outlet; particles leave towards +x
  double speed = 1;        // above 0
  double gravity = 0;      // towards -z
  std::uint64_t seed = 0;
};

class Nozzle {
 public:
  // The largest jitter along each axis, in spacings.
  static constexpr double kJitter = 0.05;

  explicit Nozzle(const NozzleOptions& options);

  // Returns the most memory that a nozzle uses, in bytes.
  [[nodiscard]] static std::uint64_t bytes(const NozzleOptions& options);

  // Returns the time at which particle `number`, counted from 0, leaves.
  [[nodiscard]] double emission_time(std::uint64_t number) const {
    const std::uint64_t layer = number / lattice_.size();
    return static_cast<double>(layer) * (options_.spacing / options_.speed);
  }

  // Calls f(place, velocity) for each particle that leaves until `time`, at most `room` times. Particles fall freely
  // after they left. The first layer leaves at time 0. Times must not decrease from call to call.
  template <class F>
  void emit(double time, std::uint64_t room, const F& f) {
    for (; room > 0 && emission_time(emitted_) <= time; --room) {
      const double age = time - emission_time(emitted_);
      const glm::dvec2& across = lattice_[static_cast<std::size_t>(emitted_ % lattice_.size())];
      const glm::dvec3 flown(options_.speed * age, 0, -options_.gravity * age * age / 2);
      f(options_.middle + glm::dvec3(0, across.x, across.y) + flown + jitter(),
        glm::dvec3(options_.speed, 0, -options_.gravity * age));
      ++emitted_;
    }
  }

 private:
  [[nodiscard]] glm::dvec3 jitter() const;

  NozzleOptions options_;
  std::vector<glm::dvec2> lattice_;
  std::uint64_t emitted_ = 0;
};

}  // namespace isoextract::simulate
