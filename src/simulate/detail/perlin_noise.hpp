// Gradient noise in three dimensions: K. Perlin, "Improving noise", SIGGRAPH 2002, with a permutation of one's own for
// each seed. Smooth (its second derivatives are continuous), 0 at the places of the integer lattice, between -1.04 and
// 1.04 in between. The same numbers on every machine.
#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

namespace isoextract::simulate {

class PerlinNoise {
 public:
  explicit PerlinNoise(std::uint64_t seed);

  // At places within +-2^31; the lattice repeats after 256 along each axis.
  [[nodiscard]] double operator()(const glm::dvec3& place) const;

 private:
  std::array<std::uint8_t, 512> permutation_{};  // twice, so that sums need no wrapping
};

// Octaves of noise added up: each of twice the frequency and half the amplitude of the one before. Octaves have
// lattices of their own, moved by fractions that the seed gives, so that their zeros lie neither at the origin nor one
// on another.
class FractalNoise {
 public:
  // 1 to 16 octaves; others are an error of the caller.
  FractalNoise(std::uint64_t seed, int octaves);

  [[nodiscard]] double operator()(const glm::dvec3& place) const;

 private:
  PerlinNoise noise_;
  std::array<glm::dvec3, 16> offsets_{};
  int octaves_;
};

}  // namespace isoextract::simulate
