// Gradient noise in three dimensions: K. Perlin, "Improving noise", SIGGRAPH 2002, with a permutation for each seed.
// Smooth (continuous second derivatives), 0 on the integer lattice, between -1.04 and 1.04 elsewhere. Equal on every
// machine.
#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

namespace isoextract::simulate {

class PerlinNoise {
 public:
  explicit PerlinNoise(std::uint64_t seed);

  // Returns the noise at a place within +-2^31; it repeats after 256 along each axis.
  [[nodiscard]] double operator()(const glm::dvec3& place) const;

 private:
  std::array<std::uint8_t, 512> permutation_{};  // stored twice, so that sums need no wrapping
};

// Sum of octaves of noise, each with twice the frequency and half the amplitude of the one before. The seed shifts the
// lattice of each octave by whole cells and a fraction, so that the zeros of an octave are neither at the origin nor at
// the zeros of other octaves.
class FractalNoise {
 public:
  // Requires 1 to 16 octaves.
  FractalNoise(std::uint64_t seed, int octaves);

  [[nodiscard]] double operator()(const glm::dvec3& place) const;

 private:
  PerlinNoise noise_;
  std::array<glm::dvec3, 16> offsets_{};
  int octaves_;
};

}  // namespace isoextract::simulate
