#include "batch/scheduler.hpp"

#include <algorithm>
#include <condition_variable>
#include <list>
#include <mutex>
#include <new>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <tbb/task_arena.h>

#include "base/allocation_error.hpp"
#include "base/stopwatch.hpp"
#include "batch/detail/frame_queue.hpp"
#include "convert/mesh_packing.hpp"
#include "files/parked_streams.hpp"

namespace isoextract::batch {
namespace {

class Scheduler {
 public:
  Scheduler(const BatchJob& batch, std::span<const std::size_t> which, const SchedulerOptions& options,
            const Context& context, FrameEvents& events, FrameReceiver* receiver, FrameSource* source)
      : batch_(batch),
        which_(which),
        options_(options),
        context_(context),
        events_(events),
        backends_(which.size() > 1 ? &kept_backends_ : nullptr),
        receiver_(receiver),
        source_(source),
        queue_(source != nullptr ? 0 : which.size(), receiver != nullptr),
        memory_of_one_(options.memory_per_frame) {}

  BatchCounts run() {
    const files::StreamKeeper keeper(context_, static_cast<std::size_t>(std::max(options_.jobs, 1)));
    {
      // This thread works too, so a single job needs no other thread.
      std::vector<std::jthread> others;
      const auto wanted = std::min<std::size_t>(static_cast<std::size_t>(std::max(options_.jobs, 1)), which_.size());
      for (std::size_t i = 1; i < wanted; ++i) {
        try {
          others.emplace_back([this] { work(); });
        } catch (const std::system_error&) {
          break;  // the other threads do the work
        }
      }
      work();
    }
    const std::unique_lock lock(mutex_);
    counts_.not_started = queue_.left();
    return counts_;
  }

 private:
  struct Running {
    Context context;
    std::uint64_t memory = 0;  // estimated need, in bytes
    bool beside_others = false;
  };

  void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return next() || nothing_left(); });
      const auto place = next();
      if (!place) break;
      run_one(*place, lock);
      changed_.notify_all();
    }
    changed_.notify_all();
  }

  [[nodiscard]] bool ended() const { return ended_ || context_.cancelled(); }
  [[nodiscard]] bool nothing_left() const {
    return ended() || (source_ == nullptr && queue_.left() == 0 && running_.empty());
  }

  // Returns whether one more frame fits into memory.
  [[nodiscard]] bool one_more_fits() const {
    if (running_.empty()) return true;
    std::uint64_t taken = 0;
    for (const Running& one : running_) taken += std::max(one.memory, memory_of_one_);
    return taken + memory_of_one_ <= context_.memory().limit();
  }

  // Returns the queue position that may start now. Takes a frame from the source if the queue is empty.
  [[nodiscard]] std::optional<std::size_t> next() {
    if (ended() || !one_more_fits()) return std::nullopt;
    if (queue_.left() == 0 && source_ != nullptr) {
      if (const auto given = source_->next()) {
        given_.push_back(*given);
        queue_.add();
      } else {
        source_ = nullptr;
      }
    }
    return queue_.next();
  }

  [[nodiscard]] std::size_t frame_at(std::size_t place) const { return which_[given_.empty() ? place : given_[place]]; }

  void run_one(std::size_t place, std::unique_lock<std::mutex>& lock) {
    const std::size_t frame = frame_at(place);
    queue_.start(place);
    const auto running = running_.insert(running_.end(), {context_.part(), memory_of_one_, !running_.empty()});
    for (Running& one : running_) one.beside_others = running_.size() > 1;
    const auto jobs = static_cast<std::size_t>(std::max(options_.jobs, 1));
    const std::size_t others = queue_.is_alone(place) ? 0 : source_ != nullptr ? jobs : queue_.left();
    const std::size_t beside = std::min(jobs, others + running_.size());
    const int threads = threads_of_one(options_.threads, beside);
    const Context own = running->context;
    lock.unlock();
    convert::Events unheard;
    convert::Events* const heard = events_.started(frame, own);
    convert::Outcome outcome;
    convert::MeshCollector held{.becomes_file = true};  // until the frame's turn
    tbb::task_arena arena(threads);
    arena.execute([&] {
      outcome = convert::run(batch_.frames[frame].job, own, heard != nullptr ? *heard : unheard, options_.extras,
                             backends_, receiver_ != nullptr ? &held : nullptr);
    });
    lock.lock();
    memory_of_one_ = std::max(memory_of_one_, outcome.reserved_memory);
    const bool turned_away = receiver_ != nullptr && outcome.done() && !wait_and_hand_over(place, held, outcome, lock);
    // Packing in the receiver may have run out of memory, too.
    const bool for_memory =
        running->beside_others && outcome.error && outcome.error->code == ErrorCode::out_of_memory && !ended();
    running_.erase(running);
    if (for_memory || turned_away) {
      for_memory ? queue_.run_again_alone(place) : queue_.run_again(place);
      ++counts_.repeated;
      return;
    }
    lock.unlock();
    const bool done = outcome.done();
    const bool kept = events_.finished(frame, outcome);
    lock.lock();
    queue_.end(place);  // Only after finished(), so that no later frame is taken if the batch ends with this one.
    ++(done ? counts_.done : counts_.failed);
    if (!kept || (options_.fail_fast && !done)) end();
  }

  // Waits for the frame's turn and hands its meshes over. Returns false if it is turned away. Frees the meshes in any
  // case.
  bool wait_and_hand_over(std::size_t place, convert::MeshCollector& held, convert::Outcome& outcome,
                          std::unique_lock<std::mutex>& lock) {
    using Turn = FrameQueue::Turn;
    changed_.wait(lock, [&] { return ended() || queue_.turn(place) != Turn::later; });
    const bool ends = ended();
    const bool taken = !ends && queue_.turn(place) == Turn::now;
    lock.unlock();
    if (ends) outcome.error = Error{ErrorCode::cancelled, "cancelled", {}};
    if (taken) {
      const Stopwatch watch;
      if (auto done = take(frame_at(place), held, outcome); !done) outcome.error = std::move(done.error());
      const StageTime time = watch.elapsed();
      const auto written = std::ranges::find(outcome.reports.rbegin(), outcome.reports.rend(),
                                             convert::StageName::write, &convert::StageReport::stage);
      if (written != outcome.reports.rend() && written->time) *written->time += time;
      outcome.total += time;
    }
    held.meshes.clear();
    lock.lock();
    return taken || ends;
  }

  Result<void> take(std::size_t frame, const convert::MeshCollector& held, convert::Outcome& outcome) {
    try {
      const auto packed = TRY(receiver_->take(frame, held));
      for (std::size_t m = 0; m < packed.size(); ++m) {
        if (packed[m].bytes_before == 0) continue;  // no triangles
        outcome.reports.push_back(convert::report_of({.id = held.ids[m],
                                                      .file = batch_.frames[frame].job.outputs.front().path,
                                                      .packing = held.packing,
                                                      .facts = packed[m]}));
      }
      return {};
    } catch (const std::bad_alloc&) {
      return tl::unexpected(allocation_error("not enough memory to write the frame", {Remedy::use, Setting::parts}));
    }
  }

  void end() {
    ended_ = true;
    for (const Running& one : running_) one.context.cancel();
  }

  const BatchJob& batch_;
  std::span<const std::size_t> which_;
  SchedulerOptions options_;
  const Context& context_;
  FrameEvents& events_;
  convert::BackendCache kept_backends_;
  convert::BackendCache* backends_;  // null for a single frame: no later frame needs the device
  FrameReceiver* receiver_;
  FrameSource* source_;             // null if it has no more frames
  std::vector<std::size_t> given_;  // frames that the source gave, by queue position

  std::mutex mutex_;  // guards the members below
  FrameQueue queue_;
  std::condition_variable changed_;
  std::list<Running> running_;
  std::uint64_t memory_of_one_;
  bool ended_ = false;
  BatchCounts counts_;
};

}  // namespace

BatchCounts run(const BatchJob& batch, std::span<const std::size_t> which, const SchedulerOptions& options,
                const Context& context, FrameEvents& events, FrameReceiver* receiver, FrameSource* source) {
  return Scheduler(batch, which, options, context, events, receiver, source).run();
}

}  // namespace isoextract::batch
