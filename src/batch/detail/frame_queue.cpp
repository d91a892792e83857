#include "batch/detail/frame_queue.hpp"

namespace isoextract::batch {

std::optional<std::size_t> FrameQueue::next() const {
  const bool repeats = !again_.empty() && (in_order_ || fresh_ == count_);
  if (!repeats && fresh_ == count_) return std::nullopt;
  const std::size_t place = repeats ? *again_.begin() : fresh_;
  // A frame that runs alone waits for all others, and all others wait for it.
  const bool waits = is_alone(place) || (running_.size() == 1 && is_alone(*running_.begin()));
  return waits && !running_.empty() ? std::nullopt : std::optional(place);
}

void FrameQueue::start(std::size_t place) {
  if (place == fresh_) {
    ++fresh_;
  } else {
    again_.erase(place);
  }
  running_.insert(place);
}

void FrameQueue::end(std::size_t place) {
  running_.erase(place);
  alone_.erase(place);
  displaced_.erase(place);
}

void FrameQueue::run_again_alone(std::size_t place) {
  run_again(place);
  alone_.insert(place);
  if (in_order_) displaced_.insert(running_.upper_bound(place), running_.end());
}

void FrameQueue::run_again(std::size_t place) {
  running_.erase(place);
  displaced_.erase(place);
  again_.insert(place);
}

FrameQueue::Turn FrameQueue::turn(std::size_t place) const {
  if (displaced_.contains(place)) return Turn::turned_away;
  // No earlier frame waits in again_: putting it back would have turned this one away.
  return *running_.begin() == place ? Turn::now : Turn::later;
}

}  // namespace isoextract::batch
