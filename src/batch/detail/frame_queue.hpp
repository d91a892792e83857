// The order of a batch's frames: which starts next, which is run again, and whose turn it is to be taken.
#pragma once

#include <cstddef>
#include <optional>
#include <set>

namespace isoextract::batch {

// Of frames by their place, 0 to count - 1. Each starts, and then is over or has to be run again. It knows no threads:
// whoever shares it guards it.
//
// Frames start in their order. One that failed for want of memory beside others has to be run again alone. Where frames
// are taken in any order that is at the end. Where they are taken in their own order, those that are made and wait for
// their turn hold memory, so it is at once: all that come after it and are not over are turned away, let go what they
// hold, and are run again; from then on one frame runs at a time.
class FrameQueue {
 public:
  FrameQueue(std::size_t count, bool in_order) : count_(count), in_order_(in_order) {}

  // The place that may start now, if one may.
  [[nodiscard]] std::optional<std::size_t> next() const;
  // Whether it starts alone, and no other beside it.
  [[nodiscard]] bool is_alone() const { return in_order_ ? one_at_a_time_ : fresh_ == count_; }
  void start(std::size_t place);

  // Of one that was started: it is over, however it ended.
  void end(std::size_t place) { running_.erase(place); }
  // Of one that was started: it failed for want of memory beside others, or was turned away.
  void run_again(std::size_t place);

  enum class Turn {
    now,          // all before it are over
    later,        // one of those has a chance to come first
    turned_away,  // it has to be run again
  };
  // Of one that was started, where frames are taken in their order. Of those that run, one at least is not told
  // `later`.
  [[nodiscard]] Turn turn(std::size_t place) const;

  // Those that have not started, or have to be run again.
  [[nodiscard]] std::size_t left() const { return count_ - fresh_ + again_.size(); }

 private:
  std::size_t count_;
  bool in_order_;
  bool one_at_a_time_ = false;
  std::size_t fresh_ = 0;          // the first that never started
  std::set<std::size_t> again_;    // to be run again
  std::set<std::size_t> running_;  // started and not over
  std::set<std::size_t> refused_;  // of those: turned away
};

}  // namespace isoextract::batch
