// The results of `info` for the frames of a sequence, as text and as JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "batch/frame_range.hpp"
#include "cli/info_report.hpp"
#include "cli/sequence_values.hpp"
#include "convert/json_values.hpp"

namespace isoextract::cli {

// The results for one frame. `min` and `max` are unset if no field was read or no sample is finite.
struct FrameSummary {
  std::int64_t frame = 0;
  std::string input;
  std::optional<double> min;
  std::optional<double> max;
  std::optional<field::SurfaceRange> passable;  // the iso values that have a surface, background included
  std::optional<double> iso;                    // the suggested value, if it separates inside from outside
  std::string method;                           // name of the method that found `iso`
  bool has_labels = false;                      // a label map or mask, which has no `iso`
  bool is_mask = false;                         // has_labels, with one label only
  std::optional<Error> error;
};

[[nodiscard]] FrameSummary summary_of(std::int64_t frame, const InputReport& report);

struct SequenceReport {
  std::string input;                     // as given: a pattern or a folder
  std::vector<FrameSummary> frames;      // in ascending order
  bool have_numbers = false;             // the names of the frames have numbers
  std::vector<batch::FrameRun> gaps;     // missing frame numbers
  std::vector<std::string> arguments;    // the input options, to repeat in an example
  std::optional<SequenceRadius> radius;  // the common radius of particles (find_sequence_radius()), if there is one
  // The report of the first readable frame; empty text and null if no frame is readable.
  std::string first_text;
  convert::Json first_json;
};

// A common iso value for all frames: the median of the frames' suggestions (of two middle values the lower).
struct SequenceIso {
  double iso = 0;
  std::size_t separates = 0;  // number of frames in which `iso` separates inside from outside
};
// Returns nullopt if no frame has a suggestion.
[[nodiscard]] std::optional<SequenceIso> iso_of(const SequenceReport& report);

[[nodiscard]] std::string text_of(const SequenceReport& report);
[[nodiscard]] convert::Json json_of(const SequenceReport& report);

}  // namespace isoextract::cli
