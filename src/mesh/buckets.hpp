// Parallel bucket sort, in linear time if buckets are small. Used, for example, for the corners at each vertex and for
// the vertices in each cell of space.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <span>
#include <utility>

#include "base/buffer.hpp"
#include "base/hash.hpp"
#include "base/parallel.hpp"

namespace isoextract::mesh {

// Entries within a bucket are sorted, so that the order of threads does not matter. T needs a strict order.
template <class T>
class Buckets {
 public:
  // place(i, put) calls put(bucket, entry) any number of times for each i below `count`. It runs twice for each i and
  // must do the same both times. The caller reserves bytes(). Throws std::bad_alloc.
  template <class Place>
  Buckets(std::size_t count, std::size_t buckets, const Place& place) : ends_(buckets) {
    std::fill(ends_.begin(), ends_.end(), std::uint64_t{0});
    const bool alone = count <= kGrain;  // small inputs need no atomics
    const auto next = [&](std::size_t bucket) {
      return alone ? ends_[bucket]++ : std::atomic_ref(ends_[bucket]).fetch_add(1, std::memory_order_relaxed);
    };
    each(count, [&](std::size_t i) { place(i, [&](std::size_t bucket, const T&) { next(bucket); }); });
    std::uint64_t total = 0;
    for (std::uint64_t& end : ends_) total += std::exchange(end, total);
    entries_ = Buffer<T>(total);
    each(count,
         [&](std::size_t i) { place(i, [&](std::size_t bucket, const T& entry) { entries_[next(bucket)] = entry; }); });
    each(buckets, [&](std::size_t bucket) {
      const std::uint64_t first = begin_of(bucket);
      std::sort(entries_.data() + first, entries_.data() + ends_[bucket]);
    });
  }

  [[nodiscard]] std::span<const T> at(std::size_t bucket) const {
    const std::uint64_t first = begin_of(bucket);
    return entries_.span().subspan(first, ends_[bucket] - first);
  }
  [[nodiscard]] std::size_t size() const { return ends_.size(); }      // number of buckets
  [[nodiscard]] std::size_t total() const { return entries_.size(); }  // number of entries

  static std::uint64_t bytes(std::uint64_t entries, std::uint64_t buckets) {
    return entries * sizeof(T) + buckets * sizeof(std::uint64_t);
  }

 private:
  static constexpr std::size_t kGrain = 1 << 12;

  template <class F>
  static void each(std::size_t count, const F& f) {
    for_each_range(count, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) f(i);
    });
  }

  [[nodiscard]] std::uint64_t begin_of(std::size_t bucket) const { return bucket == 0 ? 0 : ends_[bucket - 1]; }

  Buffer<std::uint64_t> ends_;  // counts, then the next free position, and at last the end of each bucket
  Buffer<T> entries_;
};

// Returns the bucket of a cell of space by its hash. `buckets`, the number of buckets, must not be 0.
[[nodiscard]] inline std::size_t bucket_of_cell(std::int64_t x, std::int64_t y, std::int64_t z, std::size_t buckets) {
  return hash_coordinates(static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(y), static_cast<std::uint64_t>(z)) %
         buckets;
}

}  // namespace isoextract::mesh
