// The environment of a task: its memory budget, a cancellation flag, counters and progress. Long-running functions take
// a `const Context&` as their last argument. Context() may use all memory that this process may use
// (available_memory()). None of this is global, so conversions can run side by side.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "base/progress.hpp"

namespace isoextract {

namespace files {
class OpenedFiles;  // files/detail/opened_files.hpp
}

struct Counters {
  std::atomic<std::uint64_t> bytes_read{0};  // of input files; compressed files count their compressed size
};

// A handle: copies share one state. Safe to use from several threads.
class Context {
 public:
  explicit Context(MemoryBudget memory = MemoryBudget())
      : memory_(std::move(memory)), state_(std::make_shared<State>()), opened_(std::make_shared<Opened>()) {}

  // Returns the context of a subtask: a part of this memory budget, with its own counters, progress and cancellation.
  // The subtask shares the open files of this context; files that it opens itself are closed when the part and its
  // copies are destroyed.
  [[nodiscard]] Context part() const {
    Context part(memory_.part());
    const std::lock_guard lock(opened_->mutex);
    part.opened_->before = opened_->files ? opened_->files : opened_->before;
    return part;
  }
  // Returns a context that shares the memory budget and the open files, with its own counters and progress. cancel() of
  // this context cancels it, too, but not the other way round.
  [[nodiscard]] Context beside() const {
    Context other = *this;
    other.state_ = std::make_shared<State>();
    other.state_->around = state_;
    return other;
  }

  [[nodiscard]] const MemoryBudget& memory() const { return memory_; }
  [[nodiscard]] Result<Reservation> reserve(std::uint64_t bytes, const std::string& what) const {
    return memory_.reserve(bytes, what);
  }
  [[nodiscard]] Counters& counters() const { return state_->counters; }
  [[nodiscard]] Progress& progress() const { return state_->progress; }

  // Asks the work in this context to end soon, with ErrorCode::cancelled. Safe from any thread, but not from
  // a signal handler. The batch scheduler calls it when a run ends early.
  void cancel() const { state_->cancelled.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool cancelled() const {
    const State* state = state_.get();
    while (state != nullptr && !state->cancelled.load(std::memory_order_relaxed)) state = state->around.get();
    return state != nullptr;
  }
  // Fails if cancel() was called. Long stages call this between steps.
  [[nodiscard]] Result<void> check() const {
    if (cancelled()) return fail(ErrorCode::cancelled, "cancelled");
    return {};
  }

  // Returns the table of open files, which lives as long as this context and its copies. The first call creates it by
  // make(parent): `parent` is the table of the nearest enclosing context that has one, or null. For files::InputFile.
  template <class Make>
  [[nodiscard]] std::shared_ptr<files::OpenedFiles> opened_files(const Make& make) const {
    const std::lock_guard lock(opened_->mutex);
    if (!opened_->files) opened_->files = make(opened_->before);
    return opened_->files;
  }

 private:
  struct State {
    Counters counters;
    Progress progress;
    std::atomic<bool> cancelled{false};
    std::shared_ptr<const State> around;  // of the context that beside() was called on
  };

  struct Opened {
    std::mutex mutex;
    std::shared_ptr<files::OpenedFiles> files;
    std::shared_ptr<files::OpenedFiles> before;
  };

  MemoryBudget memory_;
  std::shared_ptr<State> state_;
  std::shared_ptr<Opened> opened_;
};

}  // namespace isoextract
