// Particle sets for tests, and samples of their fields.
#pragma once

#include <algorithm>
#include <cstring>
#include <functional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "field/sparse_lookup.hpp"
#include "points/particle_field.hpp"

namespace isoextract::points {

inline ParticleSet particles_at(const std::vector<glm::dvec3>& positions) {
  ParticleSet set;
  set.label = "test.ply";
  set.positions = Buffer<glm::dvec3>(positions.size());
  std::ranges::copy(positions, set.positions.begin());
  return set;
}

// Returns the points of a cubic lattice of touching particles for which inside(p) holds.
inline std::vector<glm::dvec3> lattice(double radius, int half_count,
                                       const std::function<bool(const glm::dvec3&)>& inside, double jitter = 0) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> offset(-jitter * radius, jitter * radius);
  std::vector<glm::dvec3> positions;
  for (int x = -half_count; x <= half_count; ++x) {
    for (int y = -half_count; y <= half_count; ++y) {
      for (int z = -half_count; z <= half_count; ++z) {
        const glm::dvec3 p = 2 * radius * glm::dvec3(x, y, z);
        if (inside(p)) positions.push_back(p + glm::dvec3(offset(engine), offset(engine), offset(engine)));
      }
    }
  }
  return positions;
}

inline std::vector<glm::dvec3> lattice_ball(double radius, double ball_radius, double jitter = 0) {
  return lattice(
      radius, static_cast<int>(ball_radius / (2 * radius)) + 1,
      [&](const glm::dvec3& p) { return glm::length(p) <= ball_radius; }, jitter);
}

inline std::vector<glm::dvec3> random_positions(std::size_t count, double size, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> coordinate(0, size);
  std::vector<glm::dvec3> positions(count);
  for (glm::dvec3& p : positions) p = {coordinate(engine), coordinate(engine), coordinate(engine)};
  return positions;
}

inline ParticleField field_of(const ParticleSet& particles, const FieldOptions& options) {
  Result<ParticleField> made = make_field(particles, options, Context());
  if (!made) {
    ADD_FAILURE() << made.error().message;
    return {};
  }
  return std::move(*made);
}

inline const field::SparseSamples& samples_of(const ParticleField& made) {
  return std::get<field::SparseSamples>(made.field.samples);
}

// Calls f(index, value) for all stored samples.
template <class F>
void for_each_sample(const ParticleField& made, const F& f) {
  for (const field::SparseBlock& block : samples_of(made).blocks) {
    const auto* values = static_cast<const float*>(block.values);
    for (int v = 0; v < 512; ++v) f(block.origin + glm::ivec3(v >> 6, v >> 3 & 7, v & 7), values[v]);
  }
}

// Returns whether blocks, tiles and values are equal bit by bit.
inline bool same_samples(const field::SparseSamples& a, const field::SparseSamples& b) {
  if (a.blocks.size() != b.blocks.size() || a.tiles.size() != b.tiles.size()) return false;
  for (std::size_t n = 0; n < a.blocks.size(); ++n) {
    if (a.blocks[n].origin != b.blocks[n].origin) return false;
    if (std::memcmp(a.blocks[n].values, b.blocks[n].values, 512 * sizeof(float)) != 0) return false;
  }
  for (std::size_t n = 0; n < a.tiles.size(); ++n) {
    if (a.tiles[n].origin != b.tiles[n].origin || a.tiles[n].value != b.tiles[n].value) return false;
  }
  return a.active_box == b.active_box && a.active_voxels == b.active_voxels;
}

}  // namespace isoextract::points
