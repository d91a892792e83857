// Evaluates series of measurements: orders of convergence and the Pareto front.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace isoextract::bench {

// The order p of error ~ spacing^p.
struct ConvergenceOrder {
  double slope = 0;  // least-squares slope of log(error) over log(spacing)
  double last = 0;   // slope between the last two errors
};

// Returns the order of errors at falling spacings, one error per spacing. Returns nothing for fewer than two errors, or
// if an error is not above `floor`: such errors are rounding and follow no order.
[[nodiscard]] std::optional<ConvergenceOrder> observed_order(std::span<const double> spacings,
                                                             std::span<const double> errors, double floor);

struct Cost {
  double error = 0;
  double seconds = 0;
};

// Returns for each cost whether no other is at least as good in both values and better in one.
[[nodiscard]] std::vector<bool> pareto_front(std::span<const Cost> costs);

}  // namespace isoextract::bench
