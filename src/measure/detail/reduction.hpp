// Sums over many points, in parallel and the same for any number of threads.
#pragma once

#include <cstddef>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "base/progress.hpp"

namespace isoextract::measure {

using PointRange = tbb::blocked_range<std::size_t>;

// Runs body(range, sums) over [0, count) in pieces of at most `piece`, each into sums that start as a copy of `none`,
// and merges them with Sums::merge in an order that depends on `count` only.
template <class Sums, class Body>
[[nodiscard]] Sums reduce_in_order(std::size_t count, const Sums& none, Progress* progress, const Body& body,
                                   std::size_t piece = 1 << 13) {
  return tbb::parallel_deterministic_reduce(
      PointRange(0, count, piece), none,
      [&](const PointRange& range, Sums sums) {
        body(range, sums);
        if (progress != nullptr) progress->advance(range.size());
        return sums;
      },
      [](Sums a, const Sums& b) {
        a.merge(b);
        return a;
      });
}

}  // namespace isoextract::measure
