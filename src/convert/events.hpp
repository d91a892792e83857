// Events of a running conversion: notes and reports of its stages, on the thread that runs the conversion.
// Context::progress() tells any thread which stage runs and how far it has come.
#pragma once

#include <string>

#include "base/note.hpp"
#include "convert/stage_report.hpp"

namespace isoextract::convert {

// Override the functions of interest; by default they do nothing.
class Events {
 public:
  virtual ~Events() = default;

  // Receives a note. The notes of a report (StageReport::notes) come after end() received the report.
  virtual void note(const Note& /*note*/) {}
  // Receives a report of a stage. A stage may send several, such as one with times and one with skipped work.
  virtual void end(const StageReport& /*report*/) {}
};

}  // namespace isoextract::convert
