// Bricks of a field that is a sum of kernels, one at each spot.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "points/cell_grid.hpp"
#include "points/detail/sparse_bricks.hpp"

namespace isoextract::points {

// S(sqrt(d^T M d)) at d from the spot; `reach` is the longest half axis.
struct Ellipsoid {
  float xx;
  float xy;
  float xz;
  float yy;
  float yz;
  float zz;
  float reach;
};

// In index coordinates, by spot of the grid. Does not own what it points to.
struct KernelSet {
  const CellGrid* grid = nullptr;
  const float* weights = nullptr;         // a kernel's value at its centre
  const Ellipsoid* shapes = nullptr;      // null: all are balls
  const std::uint32_t* counts = nullptr;  // of particles a spot; null: the members of the grid's spots
  double reach = 0;                       // the radius of the balls, or the longest half axis of all
};

class KernelBricks final : public BrickSource {
 public:
  explicit KernelBricks(const KernelSet& kernels);

  [[nodiscard]] const CellGrid& grid() const override { return *kernels_.grid; }
  [[nodiscard]] double reach() const override { return kernels_.reach; }
  [[nodiscard]] std::uint64_t particles_at(std::size_t spot) const override;
  [[nodiscard]] bool touches(const glm::ivec3& origin) const override;
  void fill(const glm::ivec3& origin, float* values, const SpotMarks& marks) const override;
  [[nodiscard]] bool looks_inside(const glm::ivec3& origin) const override;
  // Kernels are nowhere below 0, so a part of the sum is a lower bound of it: that of rows near the centres, where most
  // of a kernel's integral is.
  [[nodiscard]] bool surely_above(const glm::ivec3& origin, double iso) const override;

 private:
  // f(spot) for those that come nearer than `part` of their reach to a sample's box.
  template <class F>
  void for_each_near(const glm::ivec3& origin, double part, const F& f) const;
  // Adds the rows of kernels within `part` of their reach.
  void sum(const glm::ivec3& origin, float part, float* values, const SpotMarks& marks) const;

  KernelSet kernels_;
  std::size_t crowded_ = 1;  // spots that a cell within the particles has at least
};

}  // namespace isoextract::points
