// What a conversion tells while it works, on the thread that runs it: notes, and the report of each stage that ended.
// Which stage runs and how far it has come stands in Context::progress(), for all threads to look at.
#pragma once

#include <string>

#include "convert/stage_report.hpp"

namespace isoextract::convert {

// Every function does nothing unless it is overridden.
class Events {
 public:
  virtual ~Events() = default;

  // Something that was not as one would think: a sentence without its full stop that names no option. Those of a report
  // are told after it.
  virtual void note(const std::string& /*text*/) {}
  virtual void end(const StageReport& /*report*/) {}
};

}  // namespace isoextract::convert
