// Sums over many points, in parallel and the same for any number of threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <new>

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
// and merges them with Sums::merge in an order that depends on `count` only. A copy of `none` takes no memory. Throws
// std::bad_alloc where a body or a merge did; it keeps the exception until all have ended, since one that leaves a body
// ends parallel loops within other bodies half done and without an error, and one that leaves a merge damages TBB's
// tree.
template <class Sums, class Body>
[[nodiscard]] Sums reduce_in_order(std::size_t count, const Sums& none, Progress* progress, const Body& body,
                                   std::size_t piece = 1 << 13) {
  std::atomic<bool> out_of_memory{false};
  const auto guarded = [&](const auto& work) -> Sums {
    if (!out_of_memory) {
      try {
        return work();
      } catch (const std::bad_alloc&) {
        out_of_memory = true;
      }
    }
    return none;
  };
  Sums all = reduce_ranges(
      count, piece, none,
      [&](std::size_t begin, std::size_t end, const Sums& before) {
        return guarded([&] {
          Sums sums = before;
          body(PointRange{begin, end}, sums);
          if (progress != nullptr) progress->advance(end - begin);
          return sums;
        });
      },
      [&](const Sums& a, const Sums& b) {
        return guarded([&] {
          Sums sums = a;
          sums.merge(b);
          return sums;
        });
      });
  if (out_of_memory) throw std::bad_alloc();
  return all;
}

}  // namespace isoextract
