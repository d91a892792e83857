#include "cli/stage_lines.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>
#include <map>
#include <set>
#include <string_view>
#include <system_error>
#include <tuple>
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

// The parts of a line about a label: "hollowed", ": no cavity" and 0.31 of "hollowed at label 3: no cavity; 0.31 s".
// Other lines are `start` as a whole.
struct LineParts {
  std::string start;
  std::string end = {};
  bool has_label = false;
  std::optional<double> seconds = {};
};

LineParts parts_of(const SurfaceLine& line) {
  LineParts parts{.start = line.text};
  if (!line.id || !line.id->is_label()) return parts;
  const std::string label = line.id->at_text();
  const std::size_t at = line.text.find(label);
  if (at == std::string::npos) return parts;
  std::string end = line.text.substr(at + label.size());
  if (!end.empty() && std::isdigit(static_cast<unsigned char>(end.front())) != 0) return parts;  // of a longer number
  constexpr std::string_view kUnit = " s";
  const std::size_t time = end.rfind("; ");
  if (time != std::string::npos && end.ends_with(kUnit)) {
    double seconds = 0;
    const char* const last = end.data() + end.size() - kUnit.size();
    const auto [stop, status] = std::from_chars(end.data() + time + 2, last, seconds);
    if (status == std::errc{} && stop == last) {
      parts.seconds = seconds;
      end.resize(time);
    }
  }
  parts.start.resize(at);
  parts.end = std::move(end);
  parts.has_label = true;
  return parts;
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
    stages_.push_back({report.stage, report.label, report.did, {}, 0, {}});
    stage = std::prev(stages_.end());
  }
  stage->labels.insert(report.id->label());
  if (stage->labels.size() == 1) {
    std::ranges::move(stage_lines(report), std::back_inserter(stage->lines));
  } else {
    stage->lines.clear();
  }
  stage->seconds += report.time->wall_seconds;
}

std::vector<std::string> LabelStages::take_lines(const convert::LabelTimes& times) {
  std::vector<std::string> lines;
  for (Stage& stage : std::exchange(stages_, {})) {
    if (stage.labels.size() == 1) {
      std::ranges::move(stage.lines, std::back_inserter(lines));
      continue;
    }
    const std::string start =
        fmt::format("{}: {} for {}", stage.field, stage.did, counted(stage.labels.size(), "label"));
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

std::vector<SurfaceLine> join_equal_lines(const std::vector<SurfaceLine>& lines) {
  struct Joined {
    LineParts parts;
    std::size_t count = 0;
    std::set<std::int64_t> labels = {};
  };
  std::vector<SurfaceLine> joined;
  std::vector<Joined> facts;  // of `joined`
  std::map<std::tuple<std::string, std::string, bool, bool, bool>, std::size_t> places;
  for (const SurfaceLine& line : lines) {
    LineParts parts = parts_of(line);
    const auto [place, is_new] = places.try_emplace(
        {parts.start, parts.end, parts.has_label, parts.seconds.has_value(), line.explains}, joined.size());
    if (is_new) {
      joined.push_back(line);
      facts.push_back({std::move(parts)});
    } else if (parts.seconds) {
      *facts[place->second].parts.seconds += *parts.seconds;
    }
    Joined& same = facts[place->second];
    ++same.count;
    if (same.parts.has_label) same.labels.insert(line.id->label());
  }
  for (std::size_t i = 0; i < joined.size(); ++i) {
    const auto& [parts, count, labels] = facts[i];
    if (count == 1) continue;
    std::string where;
    if (labels.size() == 1) where = joined[i].id->at_text();
    if (labels.size() > 1) where = fmt::format(" at {} labels", labels.size());
    joined[i].text = fmt::format("{}{}{}{}", parts.start, where, parts.end,
                                 parts.seconds ? fmt::format("; {:.2f} s", *parts.seconds) : "");
  }
  return joined;
}

}  // namespace isoextract::cli
