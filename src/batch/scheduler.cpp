#include "batch/scheduler.hpp"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <list>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include <tbb/task_arena.h>

namespace isoextract::batch {
namespace {

class Scheduler {
 public:
  Scheduler(const BatchJob& batch, std::span<const std::size_t> which, const SchedulerOptions& options,
            const Context& context, FrameEvents& events)
      : batch_(batch),
        waiting_(which.begin(), which.end()),
        options_(options),
        context_(context),
        events_(events),
        backends_(which.size() > 1 ? &kept_backends_ : nullptr),
        memory_of_one_(options.memory_of_one) {}

  BatchCounts run() {
    {
      // This thread is one of them, so that one job needs no other.
      std::vector<std::jthread> others;
      const auto wanted = std::min<std::size_t>(static_cast<std::size_t>(std::max(options_.jobs, 1)), waiting_.size());
      for (std::size_t i = 1; i < wanted; ++i) {
        try {
          others.emplace_back([this] { work(); });
        } catch (const std::system_error&) {
          break;  // the work gets done all the same
        }
      }
      work();
    }
    const std::unique_lock lock(mutex_);
    counts_.not_started = left() + alone_.size();
    return counts_;
  }

 private:
  struct Running {
    Context context;
    std::uint64_t memory = 0;  // that it is thought to need
    bool beside_others = false;
  };

  void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return may_start() || nothing_left(); });
      if (!may_start()) break;
      // Those that failed for want of memory come when all others are done, one at a time.
      const bool is_last_try = left() == 0;
      const std::size_t frame = is_last_try ? alone_.front() : waiting_[next_];
      is_last_try ? alone_.pop_front() : void(++next_);
      run_one(frame, is_last_try, lock);
      changed_.notify_all();
    }
    changed_.notify_all();
  }

  [[nodiscard]] bool ended() const { return ended_ || context_.cancelled(); }
  [[nodiscard]] std::size_t left() const { return waiting_.size() - next_; }

  [[nodiscard]] bool nothing_left() const { return ended() || (left() == 0 && alone_.empty() && running_.empty()); }

  [[nodiscard]] bool may_start() const {
    if (ended()) return false;
    if (running_.empty()) return left() > 0 || !alone_.empty();
    if (left() == 0) return false;
    std::uint64_t taken = 0;
    for (const Running& one : running_) taken += std::max(one.memory, memory_of_one_);
    return taken + memory_of_one_ <= context_.memory().limit();
  }

  void run_one(std::size_t frame, bool is_last_try, std::unique_lock<std::mutex>& lock) {
    const auto place =
        running_.insert(running_.end(), {Context(context_.memory().part()), memory_of_one_, !running_.empty()});
    for (Running& one : running_) one.beside_others = running_.size() > 1;
    const std::size_t beside =
        std::min<std::size_t>(static_cast<std::size_t>(std::max(options_.jobs, 1)), left() + running_.size());
    const int threads = std::max(1, options_.threads / static_cast<int>(std::max<std::size_t>(beside, 1)));
    const Context own = place->context;
    lock.unlock();
    events_.started(frame);
    convert::Events unheard;
    convert::Outcome outcome;
    tbb::task_arena arena(threads);
    arena.execute([&] {
      outcome = convert::run(batch_.frames[frame].job, own, unheard, {.mesh_facts = options_.mesh_facts}, backends_);
    });
    lock.lock();
    const bool beside_others = place->beside_others;
    running_.erase(place);
    memory_of_one_ = std::max(memory_of_one_, outcome.reserved_memory);
    if (!is_last_try && beside_others && outcome.error && is_for_memory(*outcome.error) && !ended()) {
      alone_.push_back(frame);
      ++counts_.repeated;
      return;
    }
    lock.unlock();
    const bool kept = events_.finished(frame, outcome);
    lock.lock();
    ++(outcome.done() ? counts_.done : counts_.failed);
    if (!kept || (options_.fail_fast && !outcome.done())) end();
  }

  static bool is_for_memory(const Error& error) {
    return error.hint.remedy == Remedy::raise_memory_limit || error.hint.remedy == Remedy::extract_part;
  }

  void end() {
    ended_ = true;
    for (const Running& one : running_) one.context.cancel();
  }

  const BatchJob& batch_;
  std::vector<std::size_t> waiting_;  // from next_ on
  std::size_t next_ = 0;
  std::deque<std::size_t> alone_;  // to be run again
  SchedulerOptions options_;
  const Context& context_;
  FrameEvents& events_;
  convert::KeptBackends kept_backends_;
  convert::KeptBackends* backends_;  // null for one frame, which leaves nothing to another

  std::mutex mutex_;  // of all that follows, of the lists, and while events are told
  std::condition_variable changed_;
  std::list<Running> running_;
  std::uint64_t memory_of_one_;
  bool ended_ = false;
  BatchCounts counts_;
};

}  // namespace

BatchCounts run(const BatchJob& batch, std::span<const std::size_t> which, const SchedulerOptions& options,
                const Context& context, FrameEvents& events) {
  return Scheduler(batch, which, options, context, events).run();
}

}  // namespace isoextract::batch
