#include "base/parallel.hpp"

#include <atomic>
#include <exception>
#include <memory>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/partitioner.h>

namespace isoextract::detail {
namespace {

using Range = tbb::blocked_range<std::size_t>;

// Keeps the first exception until the loop has ended. An exception that leaves a join or a split damages TBB's tree,
// and an exception that leaves a body stops the loops inside other bodies halfway.
class KeptException {
 public:
  [[nodiscard]] bool any() const { return any_; }
  template <class Work>
  void keep_from(const Work& work) {
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
  SplitReduction(Reduction& all, KeptException& kept) : all_(all), kept_(kept), part_(&all) {}
  SplitReduction(SplitReduction& other, tbb::split /*unused*/) : all_(other.all_), kept_(other.kept_) {}

  void operator()(const Range& range) {
    if (kept_.any()) return;
    kept_.keep_from([&] {
      if (part_ == nullptr) {
        own_ = all_.fresh();
        part_ = own_.get();
      }
      part_->run(range.begin(), range.end());
    });
  }
  void join(SplitReduction& later) {
    if (part_ == nullptr || later.part_ == nullptr || kept_.any()) return;  // an exception left no result
    kept_.keep_from([&] { part_->join(*later.part_); });
  }

 private:
  const Reduction& all_;
  KeptException& kept_;
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
  KeptException kept;
  SplitReduction split(all, kept);
  tbb::parallel_deterministic_reduce(Range(0, count, grain), split);
  kept.rethrow();
}

}  // namespace isoextract::detail
