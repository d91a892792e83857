// What work runs in: how much memory it may take, whether somebody wants it to end, what it counts, who watches it.
// Functions that work long take a `const Context&` as their last argument; Context() is the machine's memory, nobody
// watching. There are no process globals for any of this, so conversions can run side by side.
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
  std::atomic<std::uint64_t> bytes_read{0};  // of input files; packed bytes count as they lie in the file
};

// A handle: copies share what they stand for. Safe to use from several threads.
class Context {
 public:
  explicit Context(MemoryBudget memory = MemoryBudget())
      : memory_(std::move(memory)), state_(std::make_shared<State>()), opened_(std::make_shared<Opened>()) {}

  // Work within this work: a part of the memory, and nothing counted or cancelled yet. Files that are open here are not
  // opened again there; those that are opened there are closed with it.
  [[nodiscard]] Context part() const {
    Context part(memory_.part());
    const std::lock_guard lock(opened_->mutex);
    part.opened_->before = opened_->files ? opened_->files : opened_->before;
    return part;
  }
  // The same memory and the same open files, and nothing counted or cancelled yet.
  [[nodiscard]] Context beside() const {
    Context other = *this;
    other.state_ = std::make_shared<State>();
    return other;
  }

  [[nodiscard]] const MemoryBudget& memory() const { return memory_; }
  [[nodiscard]] Result<Reservation> reserve(std::uint64_t bytes, const std::string& what) const {
    return memory_.reserve(bytes, what);
  }
  [[nodiscard]] Counters& counters() const { return state_->counters; }
  [[nodiscard]] Progress& progress() const { return state_->progress; }

  // Asks what runs in this context to end soon, with ErrorCode::cancelled. May be called from a signal handler's
  // thread, not from the handler itself.
  void cancel() const { state_->cancelled.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool cancelled() const { return state_->cancelled.load(std::memory_order_relaxed); }
  // Fails where the end was asked for. Called between stages, and in long ones now and then.
  [[nodiscard]] Result<void> check() const {
    if (cancelled()) return fail(ErrorCode::cancelled, "cancelled");
    return {};
  }

  // For files::InputFile: the files that stay open until the context and its copies are gone. `make` makes the table
  // at the first call, of the one that part() took over, or null.
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
