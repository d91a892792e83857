#include "bench/convergence.hpp"

#include <algorithm>
#include <cmath>

namespace isoextract::bench {

std::optional<ConvergenceOrder> observed_order(std::span<const double> spacings, std::span<const double> errors,
                                               double floor) {
  const std::size_t n = errors.size();
  if (n < 2 || !std::ranges::all_of(errors, [&](double error) { return error > floor; })) return std::nullopt;
  double mean_x = 0;
  double mean_y = 0;
  for (std::size_t i = 0; i < n; ++i) {
    mean_x += std::log(spacings[i]) / static_cast<double>(n);
    mean_y += std::log(errors[i]) / static_cast<double>(n);
  }
  double products = 0;
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = std::log(spacings[i]) - mean_x;
    products += x * (std::log(errors[i]) - mean_y);
    squares += x * x;
  }
  return ConvergenceOrder{products / squares,
                          std::log(errors[n - 2] / errors[n - 1]) / std::log(spacings[n - 2] / spacings[n - 1])};
}

std::vector<bool> pareto_front(std::span<const Cost> costs) {
  std::vector<bool> front;
  for (const Cost& cost : costs) {
    front.push_back(std::ranges::none_of(costs, [&](const Cost& other) {
      return other.error <= cost.error && other.seconds <= cost.seconds &&
             (other.error < cost.error || other.seconds < cost.seconds);
    }));
  }
  return front;
}

}  // namespace isoextract::bench
