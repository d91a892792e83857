// Events of a running conversion: notes, and the report of each finished stage, on the thread that runs the conversion.
// Context::progress() tells any thread which stage runs and how far it has come.
#pragma once

#include <string>

#include "convert/stage_report.hpp"

namespace isoextract::convert {

// Override the functions of interest; by default they do nothing.
class Events {
 public:
  virtual ~Events() = default;

  // Receives a note about something unexpected: a sentence without its full stop that names no option. The notes of a
  // stage's report follow the report.
  virtual void note(const std::string& /*text*/) {}
  virtual void end(const StageReport& /*report*/) {}
};

}  // namespace isoextract::convert
