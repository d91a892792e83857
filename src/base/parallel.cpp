#include "base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

namespace isoextract {

int usable_threads() {
  const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::min(static_cast<int>(std::min<std::size_t>(allowed, 1 << 16)), tbb::this_task_arena::max_concurrency());
}

namespace detail {
namespace {

using Range = tbb::blocked_range<std::size_t>;

// Keeps the first exception until the loop has ended. An exception that leaves a join or a split damages TBB's tree,
// and an exception that leaves a body stops the loops inside other bodies halfway.
class FirstException {
 public:
  [[nodiscard]] bool any() const { return any_; }
  template <class Work>
  void run_and_keep(const Work& work) {
    try {
      work();
    } catch (...) {
      if (!any_.exchange(true)) first_ = std::current_exception();
    }
  }
  void rethrow() const {
    if (any_) std::rethrow_exception(first_);
  }

 private:
  std::atomic<bool> any_{false};
  std::exception_ptr first_;
};

// The body that TBB's reduction splits and joins.
class SplitReduction {
 public:
  SplitReduction(Reduction& all, FirstException& kept) : all_(all), kept_(kept), part_(&all) {}
  SplitReduction(SplitReduction& other, tbb::split /*unused*/) : all_(other.all_), kept_(other.kept_) {}

  void operator()(const Range& range) {
    if (kept_.any()) return;
    kept_.run_and_keep([&] {
      if (part_ == nullptr) {
        own_ = all_.fresh();
        part_ = own_.get();
      }
      part_->run(range.begin(), range.end());
    });
  }
  void join(SplitReduction& later) {
    if (part_ == nullptr || later.part_ == nullptr || kept_.any()) return;  // an exception left no result
    kept_.run_and_keep([&] { part_->join(*later.part_); });
  }

 private:
  const Reduction& all_;
  FirstException& kept_;
  std::unique_ptr<Reduction> own_;
  Reduction* part_ = nullptr;
};

}  // namespace

void parallel_ranges(std::size_t count, std::size_t grain, RangeBody body) {
  tbb::parallel_for(Range(0, count, grain),
                    [body](const Range& range) { body.run(body.body, range.begin(), range.end()); });
}

void fixed_ranges(std::size_t count, std::size_t grain, RangeBody body) {
  tbb::parallel_for(
      Range(0, count, grain), [body](const Range& range) { body.run(body.body, range.begin(), range.end()); },
      tbb::simple_partitioner());
}

void reduce_ranges(std::size_t count, std::size_t grain, Reduction& all) {
  FirstException kept;
  SplitReduction split(all, kept);
  tbb::parallel_deterministic_reduce(Range(0, count, grain), split);
  kept.rethrow();
}

}  // namespace detail
}  // namespace isoextract
