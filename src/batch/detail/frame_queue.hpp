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
// hold, and are run again after it.
class FrameQueue {
 public:
  FrameQueue(std::size_t count, bool in_order) : count_(count), in_order_(in_order) {}

  // The place that may start now, if one may.
  [[nodiscard]] std::optional<std::size_t> next() const;
  void start(std::size_t place);
  // Whether no other starts beside it.
  [[nodiscard]] bool is_alone(std::size_t place) const { return alone_.contains(place); }

  // Of one that was started: it is over, however it ended.
  void end(std::size_t place);
  // Of one that was started beside others: it has to be run again alone.
  void run_again_alone(std::size_t place);
  // Of one that was started and told that it is turned away: it has let go what it held, and is run again.
  void run_again(std::size_t place);

  enum class Turn {
    now,    // all before it are over
    later,  // one of those has a chance to come first
    turned_away,
  };
  // Of one that was started, where frames are taken in their order. Of those that run, one at least is not told
  // `later`.
  [[nodiscard]] Turn turn(std::size_t place) const;

  // Those that have not started, or have to be run again.
  [[nodiscard]] std::size_t left() const { return count_ - fresh_ + again_.size(); }

 private:
  std::size_t count_;
  bool in_order_;
  std::size_t fresh_ = 0;              // the first that never started
  std::set<std::size_t> again_;        // to be run again
  std::set<std::size_t> running_;      // started and not over
  std::set<std::size_t> alone_;        // of both: those that run alone
  std::set<std::size_t> turned_away_;  // of those that run
};

}  // namespace isoextract::batch
