#include "cli/stage_lines.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"

namespace isoextract::cli {
namespace {

std::string times_text(const StageTime& time) {
  return fmt::format("{:.2f} s ({:.2f} s of processor time)", time.wall_seconds, time.cpu_seconds);
}

// The time of a label's extraction leaves out the pass over the samples, which the report has as a part.
StageTime whole_time(const convert::StageReport& report) {
  StageTime time = *report.time;
  if (!report.id || !report.id->is_label()) return time;
  for (const convert::StageReport::Part& part : report.parts) {
    if (part.stage == convert::StageName::classify) time += part.time;
  }
  return time;
}

}  // namespace

std::vector<std::string> stage_lines(const convert::StageReport& report) {
  std::vector<std::string> lines;
  const bool has_details = !report.details.empty();
  lines.push_back(fmt::format("{}: {} in {}{}{}", report.subject, report.did, times_text(whole_time(report)),
                              has_details ? ": " : "", has_details ? report.details.front() : ""));
  for (std::size_t i = 1; i < report.details.size(); ++i) {
    lines.push_back(fmt::format("{}: {}", report.subject, report.details[i]));
  }
  return lines;
}

void LabelStages::add(const convert::StageReport& report) {
  auto stage = std::ranges::find_if(
      stages_, [&](const Stage& one) { return one.name == report.stage && one.did == report.did; });
  if (stage == stages_.end()) {
    stages_.push_back({report.stage, report.label, report.did, 0, 0, stage_lines(report)});
    stage = std::prev(stages_.end());
  }
  ++stage->labels;
  stage->seconds += report.time->wall_seconds;
}

std::vector<std::string> LabelStages::take_lines(const convert::LabelTimes& times) {
  std::vector<std::string> lines;
  for (Stage& stage : std::exchange(stages_, {})) {
    if (stage.labels == 1) {
      std::ranges::move(stage.first, std::back_inserter(lines));
      continue;
    }
    const std::string start = fmt::format("{}: {} {}", stage.field, counted(stage.labels, "label"), stage.did);
    if (stage.name == convert::StageName::extract) {
      StageTime whole = times.compare;
      whole += times.make;
      lines.push_back(fmt::format("{} in {}: {:.3f} s to compare samples, {:.3f} s to make the meshes", start,
                                  times_text(whole), times.compare.wall_seconds, times.make.wall_seconds));
    } else {
      lines.push_back(fmt::format("{} in {:.2f} s, the sum over the labels", start, stage.seconds));
    }
  }
  return lines;
}

}  // namespace isoextract::cli
