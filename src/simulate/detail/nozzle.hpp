// A round nozzle in a wall, out of which particles come in layers: a square lattice one spacing apart across the
// nozzle, and along the jet. Each is off its place on the lattice by a little that depends on the seed and on its
// number.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::simulate {

struct NozzleOptions {
  double spacing = 1;
  double radius = 1;       // centres of particles are no farther from the middle
  glm::dvec3 middle{0.0};  // where particles leave it, towards +x
  double speed = 1;        // above 0
  double gravity = 0;      // towards -z
  std::uint64_t seed = 0;
};

class Nozzle {
 public:
  // How far particles are off their places at most along each axis, in spacings.
  static constexpr double kJitter = 0.05;

  explicit Nozzle(const NozzleOptions& options);

  // What one takes at most.
  [[nodiscard]] static std::uint64_t bytes(const NozzleOptions& options);

  // When particle `number` leaves, or left.
  [[nodiscard]] double left_at(std::uint64_t number) const {
    const std::uint64_t layer = number / lattice_.size();
    return static_cast<double>(layer) * (options_.spacing / options_.speed);
  }

  // f(place, velocity) for what leaves the nozzle until `time`, beginning at 0 with the first layer, where it is then
  // in free fall; at most `room` particles. Times do not decrease from call to call.
  template <class F>
  void emit(double time, std::uint64_t room, const F& f) {
    for (; room > 0 && left_at(emitted_) <= time; --room) {
      const double age = time - left_at(emitted_);
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
