#include "cli/info_sequence.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/printable.hpp"
#include "batch/frame_range.hpp"
#include "batch/output_names.hpp"
#include "batch/output_template.hpp"
#include "cli/layout.hpp"
#include "cli/remedies.hpp"
#include "cli/values.hpp"
#include "convert/json_values.hpp"
#include "files/frame_pattern.hpp"

namespace isoextract::cli {
namespace {

constexpr std::size_t kShownFrames = 12;  // number of frames listed at the beginning and at the end

std::string runs_text(const std::vector<batch::FrameRun>& runs) { return batch::text_of(runs, batch::kShownFrameRuns); }

std::vector<batch::FrameRun> runs_of(const SequenceReport& report) {
  std::vector<std::int64_t> numbers;
  for (const FrameSummary& frame : report.frames) numbers.push_back(frame.frame);
  return batch::runs_of(numbers);
}

std::size_t failed(const SequenceReport& report) {
  return static_cast<std::size_t>(
      std::ranges::count_if(report.frames, [](const FrameSummary& frame) { return frame.error.has_value(); }));
}

// Returns the least and the greatest value over all frames.
std::optional<std::pair<double, double>> range_of(const SequenceReport& report,
                                                  std::optional<double> FrameSummary::*low,
                                                  std::optional<double> FrameSummary::*high) {
  std::optional<std::pair<double, double>> range;
  for (const FrameSummary& frame : report.frames) {
    if (!(frame.*low) || !(frame.*high)) continue;
    if (!range) range = {*(frame.*low), *(frame.*high)};
    range->first = std::min(range->first, *(frame.*low));
    range->second = std::max(range->second, *(frame.*high));
  }
  return range;
}

// `surfaces` are the options that choose the surfaces: "--iso 0.5". `joined`: all inputs give one output.
std::string example_of(const SequenceReport& report, const std::string& surfaces, bool joined = false) {
  const std::string name_of_input = report.input.substr(0, report.input.find_last_not_of('/') + 1);
  std::string stem = batch::stem_of(name_of_input);
  if (stem.empty() || stem.front() == '.') stem = "frame";
  const auto pattern = files::FramePattern::parse(stem);
  const std::string end = joined ? "" : "_{:04}";
  const std::string name = pattern && pattern->has_value() ? stem : batch::template_of(stem) + end;
  std::string arguments;
  for (const std::string& argument : report.arguments) arguments += " " + argument;
  return fmt::format("isoextract {}{} {} -o {}", shell_quoted(report.input), arguments, surfaces,
                     shell_quoted(name + ".glb"));
}

// Treats files without frame numbers in their names, each with one label, as masks of one grid.
std::string example_of_labels(const SequenceReport& report) {
  const auto other = [](const FrameSummary& frame) { return frame.has_labels && !frame.is_mask; };
  if (report.have_numbers || std::ranges::any_of(report.frames, other))
    return example_of(report, std::string(kAllLabels));
  return example_of(report, std::string(kAllMasks), true);
}

std::string iso_option(double iso) { return fmt::format("--iso {}", iso); }

// Returns the number of frames that are label maps or masks, if labels are the suggestion: no frame has an iso value.
std::size_t frames_of_labels(const SequenceReport& report) {
  if (std::ranges::any_of(report.frames, [](const FrameSummary& frame) { return frame.iso.has_value(); })) return 0;
  return static_cast<std::size_t>(std::ranges::count(report.frames, true, &FrameSummary::has_labels));
}

std::string frame_text(const FrameSummary& frame) {
  std::string text = fmt::format("{:>6}  {}", frame.frame, printable(frame.input));
  if (frame.min && frame.max) text += fmt::format("  {:.6g} to {:.6g}", *frame.min, *frame.max);
  if (frame.iso) text += fmt::format("  iso {:.6g}", *frame.iso);
  if (frame.has_labels) text += "  labels";
  if (frame.error) text += "  unreadable";
  return text;
}

}  // namespace

FrameSummary summary_of(std::int64_t frame, const InputReport& report) {
  FrameSummary summary;
  summary.frame = frame;
  summary.input = report.input;
  summary.error = report.error;
  if (!report.field) return summary;
  if (report.field->statistics.samples > 0) {
    summary.min = report.field->statistics.min;
    summary.max = report.field->statistics.max;
  }
  summary.passable = field::surface_range(report.field->field, report.field->statistics);
  summary.has_labels = report.field->labels.has_value();
  summary.is_mask = summary.has_labels && report.field->labels->map.labels.size() == 1;
  if (report.field->suggestion.separates && !summary.has_labels) {
    summary.iso = report.field->suggestion.iso;
    summary.method = report.field->suggestion.method;
  }
  return summary;
}

std::optional<SequenceIso> iso_of(const SequenceReport& report) {
  std::vector<double> isos;
  for (const FrameSummary& frame : report.frames) {
    if (frame.iso) isos.push_back(*frame.iso);
  }
  if (isos.empty()) return std::nullopt;
  std::ranges::sort(isos);
  SequenceIso all{isos[(isos.size() - 1) / 2], 0};
  all.separates = static_cast<std::size_t>(std::ranges::count_if(report.frames, [&](const FrameSummary& frame) {
    return frame.passable && frame.passable->has_surface(all.iso);
  }));
  return all;
}

std::string text_of(const SequenceReport& report) {
  NamedLines lines;
  lines.plain(printable(report.input));
  const std::size_t count = report.frames.size();
  lines.add("frames", fmt::format("{}: {}", count, runs_text(runs_of(report))));
  lines.add("missing", report.gaps.empty() ? "none" : runs_text(report.gaps));
  if (const std::size_t bad = failed(report); bad > 0)
    lines.add("unreadable", fmt::format("{} of {}", bad, counted(count, "frame")));
  if (const auto range = range_of(report, &FrameSummary::min, &FrameSummary::max)) {
    lines.add("range", fmt::format("{:.6g} to {:.6g} over all frames", range->first, range->second));
  }
  if (report.radius) {
    lines.add("radius",
              fmt::format("{:.6g} in all frames, which fits frame {}", report.radius->radius, report.radius->frame));
  }
  if (const auto iso = iso_of(report)) {
    const auto isos = range_of(report, &FrameSummary::iso, &FrameSummary::iso);
    lines.add("iso",
              fmt::format("{:.6g}, the median of the frames' suggestions ({:.6g} to {:.6g}); a surface in {} of {}",
                          iso->iso, isos->first, isos->second, iso->separates, counted(count, "frame")));
    lines.add("command", example_of(report, iso_option(iso->iso)));
  }
  if (const std::size_t labels = frames_of_labels(report); labels > 0) {
    lines.add("labels", fmt::format("{} of {} frames are label maps or masks", labels, count));
    lines.add("command", example_of_labels(report));
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (i == kShownFrames && count > 2 * kShownFrames) {
      lines.plain(fmt::format("    {}", counted(count - 2 * kShownFrames, "more frame")));
      i = count - kShownFrames;
    }
    lines.plain(frame_text(report.frames[i]));
  }
  std::string text = lines.take();
  if (!report.first_text.empty()) text += "\n" + report.first_text;
  return text;
}

convert::Json json_of(const SequenceReport& report) {
  convert::Json frames = convert::Json::array();
  for (const FrameSummary& frame : report.frames) {
    convert::Json one{{"frame", frame.frame},
                      {"input", frame.input},
                      {"min", convert::optional_json(frame.min)},
                      {"max", convert::optional_json(frame.max)},
                      {"iso", convert::optional_json(frame.iso)}};
    if (frame.error) one["error"] = {{"message", frame.error->message}, {"hint", hint_text(frame.error->hint)}};
    frames.push_back(std::move(one));
  }
  const auto range = range_of(report, &FrameSummary::min, &FrameSummary::max);
  const auto iso = iso_of(report);
  convert::Json json{{"input", report.input},
                     {"count", report.frames.size()},
                     {"missing", batch::text_of(report.gaps)},
                     {"min", range ? convert::Json(range->first) : convert::Json(nullptr)},
                     {"max", range ? convert::Json(range->second) : convert::Json(nullptr)},
                     {"radius", nullptr},
                     {"suggestion", nullptr},
                     {"frames", std::move(frames)},
                     {"first", report.first_json}};
  if (report.radius) json["radius"] = {{"radius", report.radius->radius}, {"frame", report.radius->frame}};
  if (iso) {
    json["suggestion"] = {{"iso", iso->iso},
                          {"labels", nullptr},
                          {"frames", iso->separates},
                          {"command", example_of(report, iso_option(iso->iso))}};
  } else if (const std::size_t labels = frames_of_labels(report); labels > 0) {
    json["suggestion"] = {
        {"iso", nullptr}, {"labels", "all"}, {"frames", labels}, {"command", example_of_labels(report)}};
  }
  return json;
}

}  // namespace isoextract::cli
