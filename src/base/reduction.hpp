// Sums over many points, in parallel and the same for any number of threads.
#pragma once

#include <cstddef>

#include "base/parallel.hpp"
#include "base/progress.hpp"

namespace isoextract {

class PointRange {
 public:
  PointRange(std::size_t begin, std::size_t end) : begin_(begin), end_(end) {}
  [[nodiscard]] std::size_t begin() const { return begin_; }
  [[nodiscard]] std::size_t end() const { return end_; }

 private:
  std::size_t begin_;
  std::size_t end_;
};

// Runs body(range, sums) over [0, count) in pieces of at most `piece`, each into sums that start as a copy of `none`,
// and merges them with Sums::merge in an order that depends on `count` only. Throws the first exception of a body or a
// merge once all bodies have ended, as reduce_ranges does.
template <class Sums, class Body>
[[nodiscard]] Sums reduce_in_order(std::size_t count, const Sums& none, Progress* progress, const Body& body,
                                   std::size_t piece = 1 << 13) {
  return reduce_ranges(
      count, piece, none,
      [&](std::size_t begin, std::size_t end, Sums sums) {
        body(PointRange{begin, end}, sums);
        if (progress != nullptr) progress->advance(end - begin);
        return sums;
      },
      [](Sums a, const Sums& b) {
        a.merge(b);
        return a;
      });
}

}  // namespace isoextract
