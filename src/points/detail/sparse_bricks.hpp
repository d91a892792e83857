// Sparse samples that a source gives brick by brick: only bricks that a particle reaches, and of those deep inside only
// that they are inside.
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

// Which spots had a say in a stored brick; written by several threads.
class SpotMarks {
 public:
  explicit SpotMarks(std::uint8_t* marks) : marks_(marks) {}
  void mark(std::size_t spot) const {
    if (marks_ != nullptr) std::atomic_ref<std::uint8_t>(marks_[spot]).store(1, std::memory_order_relaxed);
  }

 private:
  std::uint8_t* marks_;  // null: nobody asks
};

// `origin` is that of a block: a multiple of 8 in each axis. Safe to use from several threads.
class BrickSource {
 public:
  virtual ~BrickSource() = default;

  [[nodiscard]] virtual const CellGrid& grid() const = 0;  // in index coordinates
  [[nodiscard]] virtual double reach() const = 0;          // the farthest that a spot can be from a sample it adds to
  [[nodiscard]] virtual std::uint64_t particles_at(std::size_t spot) const = 0;

  // Whether a sample of the brick may get anything.
  [[nodiscard]] virtual bool touches(const glm::ivec3& origin) const = 0;
  // The 512 values, over whatever is there.
  virtual void fill(const glm::ivec3& origin, float* values, const SpotMarks& marks) const = 0;

  // Whether it is worth the while to ask surely_above().
  [[nodiscard]] virtual bool looks_inside(const glm::ivec3& origin) const = 0;
  // Proves that fill() would give more than `iso` for all samples; false where it cannot.
  [[nodiscard]] virtual bool surely_above(const glm::ivec3& origin, double iso) const = 0;
};

struct BrickCounts {
  std::uint64_t bricks_stored = 0;
  std::uint64_t bricks_inside = 0;       // only tiles were made of them
  std::uint64_t particles_left_out = 0;  // had no say in a stored brick
};

// Where `iso` is given, bricks whose samples and those of all 26 neighbours are proved to be above it become tiles of
// `inside`, which is to be above it too. The surface at `iso`, with vertices and gradients by samples at most two steps
// from a crossed cell, is the same bit by bit: between a sample of such a brick and one that is not above iso are at
// least eight that are.
//
// Samples that are not 0, and tiles, are the active voxels. Fails as Context::reserve() does, where more bricks
// are needed than a list of blocks can number, and where the context is cancelled.
[[nodiscard]] Result<field::SparseSamples> fill_bricks(const BrickSource& source, std::optional<double> iso,
                                                       double inside, BrickCounts& counts, const Context& context,
                                                       const std::string& label);

}  // namespace isoextract::points
