#include "simulate/detail/perlin_noise.hpp"

#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/hash.hpp"

namespace isoextract::simulate {
namespace {

// Returns the n-th pseudo-random number of a seed.
std::uint64_t random_bits(std::uint64_t seed, std::uint64_t n) { return splitmix64(splitmix64(seed) ^ n); }

// Returns a number from 0 to 1, without 1.
double random_fraction(std::uint64_t seed, std::uint64_t n) {
  return static_cast<double>(random_bits(seed, n) >> 11U) * 0x1p-53;
}

// 6 t^5 - 15 t^4 + 10 t^3: the first and second derivatives are 0 at both ends.
double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

double mix(double t, double a, double b) { return a + t * (b - a); }

// Returns the product of d with one of twelve gradients towards the middles of a cube's edges; four occur twice.
double along_gradient(std::uint8_t hash, const glm::dvec3& d) {
  const unsigned h = hash & 15U;
  const double u = h < 8 ? d.x : d.y;
  const double v = h < 4 ? d.y : h == 12 || h == 14 ? d.x : d.z;
  return ((h & 1U) == 0 ? u : -u) + ((h & 2U) == 0 ? v : -v);
}

}  // namespace

PerlinNoise::PerlinNoise(std::uint64_t seed) {
  const auto first = permutation_.begin();
  std::iota(first, first + 256, std::uint8_t{0});
  for (std::size_t left = 256; left > 1; --left) {  // Fisher and Yates
    std::swap(permutation_[left - 1], permutation_[random_bits(seed, left) % left]);
  }
  std::copy(first, first + 256, first + 256);
}

double PerlinNoise::operator()(const glm::dvec3& place) const {
  const glm::dvec3 corner = glm::floor(place);
  const glm::dvec3 d = place - corner;
  const auto wrapped = [](double c) { return static_cast<std::size_t>(static_cast<std::int64_t>(c) & 255); };
  const std::size_t x = wrapped(corner.x);
  const std::size_t y = wrapped(corner.y);
  const std::size_t z = wrapped(corner.z);
  const auto& p = permutation_;
  const auto corner_of = [&](std::size_t dx, std::size_t dy, std::size_t dz) {
    const std::size_t row = p[p[x + dx] + y + dy];
    return along_gradient(p[row + z + dz], d - glm::dvec3(dx, dy, dz));
  };
  const double u = fade(d.x);
  const double v = fade(d.y);
  const auto layer = [&](std::size_t dz) {
    return mix(v, mix(u, corner_of(0, 0, dz), corner_of(1, 0, dz)), mix(u, corner_of(0, 1, dz), corner_of(1, 1, dz)));
  };
  return mix(fade(d.z), layer(0), layer(1));
}

FractalNoise::FractalNoise(std::uint64_t seed, int octaves) : noise_(seed), octaves_(octaves) {
  assert(octaves >= 1 && octaves <= static_cast<int>(offsets_.size()));
  for (std::size_t o = 0; o < offsets_.size(); ++o) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint64_t n = 1000 + 3 * o + static_cast<std::uint64_t>(axis);  // not used by the permutation
      // The integer part separates the octaves, the fraction keeps the origin off the lattice.
      offsets_[o][axis] = std::floor(256 * random_fraction(seed, n)) + 0.25 + 0.5 * random_fraction(seed, n + 1000);
    }
  }
}

double FractalNoise::operator()(const glm::dvec3& place) const {
  double sum = 0;
  double frequency = 1;
  double amplitude = 1;
  for (int o = 0; o < octaves_; ++o) {
    sum += amplitude * noise_(frequency * place + offsets_[static_cast<std::size_t>(o)]);
    frequency *= 2;
    amplitude *= 0.5;
  }
  return sum;
}

}  // namespace isoextract::simulate
