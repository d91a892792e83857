// Holds events until they are sent, so that surfaces made side by side report their events in the job's order.
#pragma once

#include <utility>
#include <variant>
#include <vector>

#include "convert/events.hpp"

namespace isoextract::convert {

class HeldEvents final : public Events {
 public:
  void note(const Note& note) override { held_.emplace_back(note); }
  void end(const StageReport& report) override { held_.emplace_back(report); }

  // Sends the events in the order they came in, and forgets them.
  void send(Events& events) {
    for (const auto& event : std::exchange(held_, {})) {
      if (const auto* note = std::get_if<Note>(&event)) events.note(*note);
      if (const auto* report = std::get_if<StageReport>(&event)) events.end(*report);
    }
  }

 private:
  std::vector<std::variant<Note, StageReport>> held_;
};

}  // namespace isoextract::convert
