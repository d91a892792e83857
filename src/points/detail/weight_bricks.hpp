// Computes bricks of a field to which each particle adds a fixed weight (Method::weight).
#pragma once

#include "points/detail/sparse_bricks.hpp"
#include "points/method.hpp"

namespace isoextract::points {

// Sums each sample in double and rounds once. Stores all bricks; none become tiles.
class WeightBricks final : public BrickSource {
 public:
  WeightBricks(const CellGrid& grid, Deposit deposit, double weight)
      : grid_(grid), deposit_(deposit), weight_(weight) {}

  [[nodiscard]] const CellGrid& grid() const override { return grid_; }
  [[nodiscard]] double reach() const override { return 1; }
  [[nodiscard]] std::uint64_t particles_at(std::size_t spot) const override { return grid_.members(spot).size(); }
  [[nodiscard]] bool touches(const glm::ivec3& origin) const override;
  void fill(const glm::ivec3& origin, float* values, const ContributingSpots& marks) const override;
  [[nodiscard]] bool is_probably_inside(const glm::ivec3& /*origin*/) const override { return false; }
  [[nodiscard]] bool is_proved_above(const glm::ivec3& /*origin*/, double /*iso*/) const override { return false; }

 private:
  // Calls f(spot, slot, share) for every sample of the brick that gets a contribution; `slot` is its index in the
  // brick.
  template <class F>
  void for_each_share(const glm::ivec3& origin, const F& f) const;

  const CellGrid& grid_;
  Deposit deposit_;
  double weight_;
};

}  // namespace isoextract::points
