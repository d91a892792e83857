// Forwards events to the listener, and records them in the outcome.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/active_time.hpp"
#include "base/note.hpp"
#include "convert/events.hpp"
#include "convert/outcome.hpp"

namespace isoextract::convert {

// The time that the labels of a grid have taken so far.
struct LabelWork {
  StageTime finding;
  ActiveTime extracting;

  // Reports the time, and begins anew.
  void end(Events& events) { events.end_labels({std::exchange(finding, {}), extracting.take()}); }
};

class Recorder final : public Events {
 public:
  Recorder(Outcome& outcome, Events& listener) : outcome_(outcome), listener_(listener) {}

  void note(const Note& note) override;
  void end(const StageReport& report) override;
  void end_labels(const LabelTimes& times) override { listener_.end_labels(times); }

  // Call before reading a grid, in jobs with several grids. For a grid that was read before, the recorder drops all
  // notes until end_reading(), and reduces reports to the time and, for reading stages, StageReport::did.
  void begin_grid(const std::optional<std::string>& grid);
  void end_reading() { again_ = false; }
  // Returns the label of the current grid; empty if the job has only one.
  [[nodiscard]] const std::string& grid() const { return grid_; }
  // Sets the label of the grid that was read; reports on surfaces then name it.
  void name_grid(const std::string& grid) { grid_ = grid; }

 private:
  Outcome& outcome_;
  Events& listener_;
  std::vector<std::optional<std::string>> begun_;
  std::set<Note> told_;  // each note once: many files of one input, such as masks, have the same notes
  bool again_ = false;
  std::string grid_;
};

}  // namespace isoextract::convert
