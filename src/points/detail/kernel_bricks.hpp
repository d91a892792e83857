// Computes bricks of a field that is a sum of kernels, one at each spot.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "points/cell_grid.hpp"
#include "points/detail/sparse_bricks.hpp"

namespace isoextract::points {

// A kernel S(sqrt(d^T M d)), with d relative to the spot; `reach` is the longest semi-axis.
struct Ellipsoid {
  float xx;
  float xy;
  float xz;
  float yy;
  float yz;
  float zz;
  float reach;
};

// In index coordinates; one entry per spot of the grid. Does not own the arrays.
struct KernelSet {
  const CellGrid* grid = nullptr;
  const float* weights = nullptr;         // value of each kernel at its center
  const Ellipsoid* shapes = nullptr;      // null: all kernels are balls
  const std::uint32_t* counts = nullptr;  // particles per spot; null: as many as the grid's spots have members
  double reach = 0;                       // radius of the balls, or the longest semi-axis of all ellipsoids
};

class KernelBricks final : public BrickSource {
 public:
  explicit KernelBricks(const KernelSet& kernels);

  [[nodiscard]] const CellGrid& grid() const override { return *kernels_.grid; }
  [[nodiscard]] double reach() const override { return kernels_.reach; }
  [[nodiscard]] std::uint64_t particles_at(std::size_t spot) const override;
  [[nodiscard]] bool touches(const glm::ivec3& origin) const override;
  void fill(const glm::ivec3& origin, float* values, const ContributingSpots& marks) const override;
  [[nodiscard]] bool is_probably_inside(const glm::ivec3& origin) const override;
  // Sums only rows of samples near kernel centers, which hold most of a kernel's integral. Kernels are never negative,
  // so this partial sum is a lower bound of the full sum. If the bound is only slightly too low, sums everything: an
  // unproved brick within the liquid costs the storage of 27 bricks.
  [[nodiscard]] bool is_proved_above(const glm::ivec3& origin, double iso) const override;

 private:
  // Calls f(spot) for spots closer to the brick's samples than `part` of their kernel's reach, until f returns false.
  template <class F>
  void for_each_near(const glm::ivec3& origin, double part, const F& f) const;
  // Adds the rows of samples within `part` of each kernel's reach.
  void sum(const glm::ivec3& origin, float part, float* values, const ContributingSpots& marks) const;

  KernelSet kernels_;
  std::size_t min_interior_spots_ = 1;  // smallest number of spots of a cell that probably lies inside
};

}  // namespace isoextract::points
