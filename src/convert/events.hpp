// Events of a running conversion: notes and reports of its stages, on the thread that runs the conversion.
// Context::progress() tells any thread which stage runs and how far it has come.
#pragma once

#include <string>

#include "base/note.hpp"
#include "base/stopwatch.hpp"
#include "convert/stage_report.hpp"

namespace isoextract::convert {

// How long the extraction of labels took. StageReport::time of one label cannot tell: labels are made side by side, and
// the samples are compared once for all of them.
struct LabelTimes {
  StageTime compare;  // the pass over the samples
  StageTime make;     // making the meshes, without the stages that edit them
};

// Override the functions of interest; by default they do nothing.
class Events {
 public:
  virtual ~Events() = default;

  // Receives a note. The notes of a report (StageReport::notes) come after end() received the report.
  virtual void note(const Note& /*note*/) {}
  // Receives a report of a stage. A stage may send several, such as one with times and one with skipped work.
  virtual void end(const StageReport& /*report*/) {}
  // Receives the times of all labels of a grid, after the reports of their stages.
  virtual void end_labels(const LabelTimes& /*times*/) {}
};

}  // namespace isoextract::convert
