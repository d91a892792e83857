#include "batch/detail/frame_queue.hpp"

namespace isoextract::batch {

std::optional<std::size_t> FrameQueue::next() const {
  const bool repeats = !again_.empty() && (in_order_ || fresh_ == count_);
  if (!repeats && fresh_ == count_) return std::nullopt;
  const std::size_t position = repeats ? *again_.begin() : fresh_;
  // A frame that runs alone waits for all others, and all others wait for it.
  const bool waits = is_alone(position) || (running_.size() == 1 && is_alone(*running_.begin()));
  return waits && !running_.empty() ? std::nullopt : std::optional(position);
}

void FrameQueue::start(std::size_t position) {
  if (position == fresh_) {
    ++fresh_;
  } else {
    again_.erase(position);
  }
  running_.insert(position);
}

void FrameQueue::end(std::size_t position) {
  running_.erase(position);
  alone_.erase(position);
  turned_away_.erase(position);
}

void FrameQueue::run_again_alone(std::size_t position) {
  run_again(position);
  alone_.insert(position);
  if (in_order_) turned_away_.insert(running_.upper_bound(position), running_.end());
}

void FrameQueue::run_again(std::size_t position) {
  running_.erase(position);
  turned_away_.erase(position);
  again_.insert(position);
}

FrameQueue::Turn FrameQueue::turn(std::size_t position) const {
  if (turned_away_.contains(position)) return Turn::turned_away;
  // No earlier frame waits in again_: putting it back would have turned this one away.
  return *running_.begin() == position ? Turn::now : Turn::later;
}

}  // namespace isoextract::batch
