// Parallel sums over many points, with the same result for any number of threads.
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

// Runs body(range, sums) on ranges of at most `piece` indices that cover [0, count). The sums of each range start as a
// copy of `none`; Sums::merge(later) joins them in an order that depends on `count` and `piece` only. Throws the first
// exception of a body or a merge once all bodies have ended, as reduce_ranges does. Advances `progress`, which may be
// null, by the indices of each range.
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
