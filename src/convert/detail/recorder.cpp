#include "convert/detail/recorder.hpp"

#include <algorithm>
#include <utility>

namespace isoextract::convert {

void Recorder::begin_grid(const std::optional<std::string>& grid) {
  again_ = std::ranges::find(begun_, grid) != begun_.end();
  if (!again_) begun_.push_back(grid);
}

void Recorder::note(const Note& note) {
  if (again_ || !told_.insert(note).second) return;
  outcome_.notes.push_back(note);
  listener_.note(note);
}

void Recorder::end(const StageReport& report) {
  StageReport told = report;
  if (again_) {
    told = StageReport(report.stage, report.subject, report.label);
    told.time = report.time;
    if (report.stage == StageName::read || report.stage == StageName::read_attributes) told.did = report.did;
  } else if (report.id && !report.label.empty()) {
    told.grid = grid_;
  }
  if (again_ && !told.time) return;
  listener_.end(told);
  // Only listeners use the sentences. A map of 100,000 labels has as many of them.
  std::vector<std::string>().swap(told.details);
  std::vector<StageReport::Line>().swap(told.lines);
  outcome_.reports.push_back(std::move(told));
}

}  // namespace isoextract::convert
