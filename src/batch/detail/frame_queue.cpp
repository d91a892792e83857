#include "batch/detail/frame_queue.hpp"

namespace isoextract::batch {

std::optional<std::size_t> FrameQueue::next() const {
  if (is_alone() && !running_.empty()) return std::nullopt;
  if (is_alone() && !again_.empty()) return *again_.begin();
  return fresh_ < count_ ? std::optional(fresh_) : std::nullopt;
}

void FrameQueue::start(std::size_t place) {
  if (place == fresh_) {
    ++fresh_;
  } else {
    again_.erase(place);
  }
  running_.insert(place);
}

void FrameQueue::run_again(std::size_t place) {
  running_.erase(place);
  refused_.erase(place);
  again_.insert(place);
  if (!in_order_) return;
  one_at_a_time_ = true;
  refused_.insert(running_.upper_bound(place), running_.end());
}

FrameQueue::Turn FrameQueue::turn(std::size_t place) const {
  if (refused_.contains(place)) return Turn::turned_away;
  const bool others_run = !running_.empty() && *running_.begin() < place;
  const bool others_wait = !again_.empty() && *again_.begin() < place;
  return others_run || others_wait ? Turn::later : Turn::now;
}

}  // namespace isoextract::batch
