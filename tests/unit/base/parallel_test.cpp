#include "base/parallel.hpp"

#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_reduce.h>

namespace isoextract {
namespace {

using Ranges = std::set<std::pair<std::size_t, std::size_t>>;

// Terms whose floating-point sum depends on the order of addition.
double term(std::size_t i) { return std::sin(static_cast<double>(i)) * std::exp(static_cast<double>(i % 40)); }

double add_terms(std::size_t begin, std::size_t end, double sum) {
  for (std::size_t i = begin; i != end; ++i) sum += term(i);
  return sum;
}

TEST(Parallel, VisitsEachIndexOnce) {
  for (const int count : {0, 1, 7, 100'000}) {
    std::vector<std::atomic<int>> seen(static_cast<std::size_t>(count));
    for_each_index(count, [&](int i) { ++seen[static_cast<std::size_t>(i)]; });
    for (const auto& times : seen) ASSERT_EQ(times, 1) << count;
  }
}

TEST(Parallel, IgnoresNegativeCount) {
  for_each_index(-3, [](int i) { FAIL() << i; });
}

TEST(Parallel, FixedRangesDependOnCountOnly) {
  const auto ranges_of = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    std::mutex lock;
    Ranges ranges;
    for_each_fixed_range(10'000, 64, [&](std::size_t begin, std::size_t end) {
      const std::lock_guard guard(lock);
      ranges.emplace(begin, end);
    });
    return ranges;
  };
  const Ranges alone = ranges_of(1);
  EXPECT_EQ(alone, ranges_of(4));
  std::size_t next = 0;
  for (const auto& [begin, end] : alone) {
    EXPECT_EQ(begin, next);
    EXPECT_LE(end - begin, 64);
    next = end;
  }
  EXPECT_EQ(next, 10'000);
}

// Sums in reports depend on the order of joins, bit for bit: it must stay that of TBB.
TEST(Parallel, ReducesLikeTbbDeterministicReduce) {
  for (const std::size_t threads : {1, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    for (const std::size_t count : {0, 1, 63, 64, 65, 12'345}) {
      const double expected = tbb::parallel_deterministic_reduce(
          tbb::blocked_range<std::size_t>(0, count, 64), 0.0,
          [](const auto& range, double sum) { return add_terms(range.begin(), range.end(), sum); }, std::plus<>());
      EXPECT_EQ(reduce_ranges(count, 64, 0.0, add_terms, std::plus<>()), expected) << count;
    }
  }
}

TEST(Parallel, JoinsResultsInOrder) {
  const auto append = [](std::vector<std::size_t> into, const std::vector<std::size_t>& more) {
    into.insert(into.end(), more.begin(), more.end());
    return into;
  };
  const auto all = reduce_ranges(
      5000, 16, std::vector<std::size_t>{},
      [](std::size_t begin, std::size_t end, std::vector<std::size_t> part) {
        for (std::size_t i = begin; i != end; ++i) part.push_back(i);
        return part;
      },
      append);
  std::vector<std::size_t> expected(5000);
  std::iota(expected.begin(), expected.end(), std::size_t{0});
  EXPECT_EQ(all, expected);
}

TEST(Parallel, RethrowsExceptionOfBody) {
  EXPECT_THROW(for_each_index(1000, [](int i) { i == 500 ? throw std::bad_alloc() : void(); }), std::bad_alloc);
  const auto body = [](std::size_t begin, std::size_t end, int part) {
    return begin <= 500 && 500 < end ? throw std::bad_alloc() : part;
  };
  EXPECT_THROW(static_cast<void>(reduce_ranges(1000, 8, 0, body, std::plus<>())), std::bad_alloc);
}

// The first `last` copies succeed, later ones throw.
class FailingCopies {
 public:
  explicit FailingCopies(int last) : left_(std::make_shared<std::atomic<int>>(last)) {}
  FailingCopies(const FailingCopies& other) : left_(other.left_) {
    if (--*left_ < 0) throw std::bad_alloc();
  }
  FailingCopies(FailingCopies&&) = default;
  FailingCopies& operator=(const FailingCopies&) = default;
  FailingCopies& operator=(FailingCopies&&) = default;
  ~FailingCopies() = default;

 private:
  std::shared_ptr<std::atomic<int>> left_;
};

TEST(Parallel, FinishesInnerLoopWhenCopyFails) {
  std::atomic<int> begun{0};
  std::atomic<int> done{0};
  const auto body = [&](std::size_t /*begin*/, std::size_t /*end*/, FailingCopies part) {
    ++begun;
    std::atomic<int> indices{0};
    for_each_index(2000, [&](int) { ++indices; });
    done += indices == 2000 ? 1 : 0;
    return part;
  };
  const auto join = [](FailingCopies a, const FailingCopies&) { return a; };
  EXPECT_THROW(static_cast<void>(reduce_ranges(256, 1, FailingCopies(5), body, join)), std::bad_alloc);
  EXPECT_GT(begun, 0);
  EXPECT_EQ(done, begun);
}

TEST(Parallel, FinishesInnerLoopWhenOtherBodyFails) {
  std::atomic<int> begun{0};
  std::atomic<int> done{0};
  const auto body = [&](std::size_t begin, std::size_t /*end*/, int part) {
    if (begin % 64 == 63) throw std::bad_alloc();
    ++begun;
    std::atomic<int> indices{0};
    for_each_index(20'000, [&](int) { ++indices; });
    done += indices == 20'000 ? 1 : 0;
    return part;
  };
  for (int round = 0; round < 20; ++round) {
    EXPECT_THROW(static_cast<void>(reduce_ranges(256, 1, 0, body, std::plus<>())), std::bad_alloc);
  }
  EXPECT_GT(begun, 0);
  EXPECT_EQ(done, begun);
}

TEST(Parallel, RethrowsExceptionOfJoin) {
  const auto body = [](std::size_t begin, std::size_t end, int part) { return part + static_cast<int>(end - begin); };
  const auto join = [](int a, int b) -> int { return a + b > 100 ? throw std::bad_alloc() : a + b; };
  EXPECT_THROW(static_cast<void>(reduce_ranges(1000, 8, 0, body, join)), std::bad_alloc);
}

}  // namespace
}  // namespace isoextract
