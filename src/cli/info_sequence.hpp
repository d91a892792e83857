// What `info` found out about the frames of a sequence, and its two ways onto paper.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "batch/frame_range.hpp"
#include "cli/info_report.hpp"
#include "convert/json_values.hpp"

namespace isoextract::cli {

// One frame; the range of values where a field was read.
struct FrameSummary {
  std::int64_t frame = 0;
  std::string input;
  std::optional<double> min;
  std::optional<double> max;
  std::optional<field::SurfaceRange> passed;
  std::optional<double> iso;  // the suggestion, where it separates inside from outside
  std::string method;         // by which that was found
  std::optional<Error> error;
};

[[nodiscard]] FrameSummary summary_of(std::int64_t frame, const InputReport& report);

struct SequenceReport {
  std::string input;                   // as it was given: a pattern or a folder
  std::vector<FrameSummary> frames;    // by their numbers
  std::vector<batch::FrameRun> gaps;   // numbers that are not there
  std::vector<std::string> arguments;  // the input options, to repeat in an example
  // What is told of the first frame that can be read; empty and null where there is none.
  std::string first_text;
  convert::Json first_json;
};

// An iso value for all frames: the median of the suggestions.
struct SequenceIso {
  double iso = 0;
  std::size_t separates = 0;  // in so many frames
};
[[nodiscard]] std::optional<SequenceIso> iso_of(const SequenceReport& report);

[[nodiscard]] std::string text_of(const SequenceReport& report);
[[nodiscard]] convert::Json json_of(const SequenceReport& report);

}  // namespace isoextract::cli
