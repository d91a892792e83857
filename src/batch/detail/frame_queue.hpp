// The order of a batch's frames: which starts next, which runs again, and whose result is received next.
#pragma once

#include <cstddef>
#include <optional>
#include <set>

namespace isoextract::batch {

// A queue of frames by position, 0 to count - 1. Each frame starts, and then ends or runs again. Not safe to use from
// several threads without a lock.
//
// Frames start in order. A frame that ran out of memory beside others runs again alone: after all other frames, if the
// batch's receiver (FrameReceiver) takes results in any order. With `in_order`, converted frames hold memory until the
// receiver has all earlier ones, so the failed frame runs again at once. The queue then turns away all later running
// frames: they free their memory and run again later.
class FrameQueue {
 public:
  FrameQueue(std::size_t count, bool in_order) : count_(count), in_order_(in_order) {}

  // Adds a frame at the end.
  void add() { ++count_; }
  // Returns the position that may start now, or nullopt.
  [[nodiscard]] std::optional<std::size_t> next() const;
  void start(std::size_t position);
  // Returns whether no other frame starts beside this one.
  [[nodiscard]] bool is_alone(std::size_t position) const { return alone_.contains(position); }

  // Ends a started frame, whatever its result.
  void end(std::size_t position);
  // Puts a started frame back, to run again alone.
  void run_again_alone(std::size_t position);
  // Puts back a started frame that was turned away and has freed its memory.
  void run_again(std::size_t position);

  enum class Turn {
    now,    // all earlier frames have ended
    later,  // an earlier frame has not ended
    turned_away,
  };
  // Returns the turn of a started frame; call only with `in_order`. At least one running frame's turn is not `later`.
  [[nodiscard]] Turn turn(std::size_t position) const;

  // Returns the number of frames that have not started or have to run again.
  [[nodiscard]] std::size_t left() const { return count_ - fresh_ + again_.size(); }

 private:
  std::size_t count_;
  bool in_order_;
  std::size_t fresh_ = 0;              // the first position that never started
  std::set<std::size_t> again_;        // to run again
  std::set<std::size_t> running_;      // started and not ended
  std::set<std::size_t> alone_;        // to run alone, from again_ or running_
  std::set<std::size_t> turned_away_;  // running frames that were turned away
};

}  // namespace isoextract::batch
