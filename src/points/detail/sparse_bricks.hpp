// Builds sparse samples from a source that computes one brick at a time. Stores only bricks within reach of a particle;
// bricks deep inside become tiles.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/samples.hpp"
#include "points/cell_grid.hpp"

namespace isoextract::points {

// Marks the spots that contribute to a stored brick. Safe to use from several threads.
class ContributingSpots {
 public:
  explicit ContributingSpots(std::uint8_t* marks) : marks_(marks) {}
  void mark(std::size_t spot) const {
    if (marks_ != nullptr) std::atomic_ref<std::uint8_t>(marks_[spot]).store(1, std::memory_order_relaxed);
  }

 private:
  std::uint8_t* marks_;  // null: marks are not needed
};

// Computes bricks of 8^3 samples. `origin` is the index of a brick's first sample, a multiple of 8 in each axis. Safe
// to use from several threads.
class BrickSource {
 public:
  virtual ~BrickSource() = default;

  [[nodiscard]] virtual const CellGrid& grid() const = 0;  // in index coordinates
  [[nodiscard]] virtual double reach() const = 0;          // largest distance along an axis from a spot to a sample
                                                           // that it contributes to
  [[nodiscard]] virtual std::uint64_t particles_at(std::size_t spot) const = 0;

  // Returns whether a sample of the brick may get a contribution.
  [[nodiscard]] virtual bool touches(const glm::ivec3& origin) const = 0;
  // Writes the 512 values, overwriting the previous ones.
  virtual void fill(const glm::ivec3& origin, float* values, const ContributingSpots& marks) const = 0;

  // Returns whether is_proved_above() is likely to succeed.
  [[nodiscard]] virtual bool is_probably_inside(const glm::ivec3& origin) const = 0;
  // Returns true if it can prove that fill() would give more than `iso` for every sample.
  [[nodiscard]] virtual bool is_proved_above(const glm::ivec3& origin, double iso) const = 0;
};

struct BrickCounts {
  std::uint64_t bricks_stored = 0;
  std::uint64_t inside_tiles = 0;           // replaced by tiles
  std::uint64_t particles_deep_inside = 0;  // contribute to no stored brick
};

// Computes the bricks. If `iso` is given, replaces deep ones by tiles of value `inside`, which must be above iso. A
// brick is deep if all samples of it and of its 26 neighbors are proved to be above iso. A sample of such a brick is
// then at least eight samples away from any sample not above iso. So the surface at `iso` stays bit-identical, as
// vertices and gradients use samples at most two steps from a crossed cell.
//
// If `needed` is given, computes only bricks that have a sample in it.
//
// Nonzero samples and tiles are the active voxels. Fails as Context::reserve() does, if more bricks are needed than
// block indices can number, and if the context is cancelled.
[[nodiscard]] Result<field::SparseSamples> fill_bricks(const BrickSource& source, std::optional<double> iso,
                                                       double inside, const std::optional<field::IndexBox>& needed,
                                                       BrickCounts& counts, const Context& context,
                                                       const std::string& label);

}  // namespace isoextract::points
