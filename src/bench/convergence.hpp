// What a series of measurements says: orders of convergence, and what nothing beats.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace isoextract::bench {

// The p of error ~ spacing^p.
struct ConvergenceOrder {
  double slope = 0;  // of the least-squares line through all of log(error) over log(spacing)
  double last = 0;   // between the last two
};

// Of errors that fall with the spacing; both in order of falling spacing. Nothing for fewer than two, or where one of
// the errors is not above `floor`, below which they are rounding and follow no order.
[[nodiscard]] std::optional<ConvergenceOrder> observed_order(std::span<const double> spacings,
                                                             std::span<const double> errors, double floor);

struct Cost {
  double error = 0;
  double seconds = 0;
};

// For each whether it is on the Pareto front: no other is at least as good in both and better in one.
[[nodiscard]] std::vector<bool> pareto_front(std::span<const Cost> costs);

}  // namespace isoextract::bench
