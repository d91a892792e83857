// Events on their way to whoever listens, written into the outcome.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "convert/events.hpp"
#include "convert/outcome.hpp"

namespace isoextract::convert {

class Recorder final : public Events {
 public:
  Recorder(Outcome& outcome, Events& listener) : outcome_(outcome), listener_(listener) {}

  void note(const std::string& text) override;
  void end(const StageReport& report) override;

  // Call it in jobs with several grids before one is read: reports on surfaces name that grid from then on. If the grid
  // was read before, what is reported until end_reading() was reported then: only times are recorded.
  void begin_grid(const std::optional<std::string>& grid);
  void end_reading() { again_ = false; }
  // The label of that grid; empty where the job has one.
  [[nodiscard]] const std::string& grid() const { return grid_; }
  void name_grid(const std::string& grid) { grid_ = grid; }

 private:
  Outcome& outcome_;
  Events& listener_;
  std::vector<std::optional<std::string>> begun_;
  bool again_ = false;
  std::string grid_;
};

}  // namespace isoextract::convert
