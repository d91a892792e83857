// Formats what stages report: the times that --verbose prints, a line for each stage and one for a stage of several
// labels, and the lines below the line about a file.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "convert/events.hpp"

namespace isoextract::cli {

// Returns "fire.vdb: read in 0.10 s (0.20 s of processor time)", with the first detail in the same line and a line for
// each of the others. The report has a time. The time of a label's extraction includes the pass over the samples.
[[nodiscard]] std::vector<std::string> stage_lines(const convert::StageReport& report);

// The stages of a grid's labels, together: a map may have thousands of labels.
class LabelStages {
 public:
  // Adds a stage of one label, which has a time.
  void add(const convert::StageReport& report);

  // Returns the lines in the order of the stages, and forgets the stages. One label has the lines of its stages.
  // Several labels have one line for each stage, without its details.
  [[nodiscard]] std::vector<std::string> take_lines(const convert::LabelTimes& times);

 private:
  struct Stage {
    convert::StageName name = convert::StageName::open;
    std::string field;  // label of the field
    std::string did;
    std::set<std::int64_t> labels;   // a label that is split into bodies has a report for each of them
    double seconds = 0;              // wall time, summed over the labels
    std::vector<std::string> lines;  // of the only label
  };

  std::vector<Stage> stages_;
};

// A line below the line about a file.
struct SurfaceLine {
  std::string text;
  std::optional<convert::SurfaceId> id;  // of the surface that it is about
  bool explains = false;                 // printed only with explanations
  int rank = 0;                          // of its stage
};

// Joins equal lines. Lines about labels are equal if only the label and the time at the end differ; the joined line has
// the sum of the times: "no triangles intersect at 40 labels; 0.31 s".
[[nodiscard]] std::vector<SurfaceLine> join_equal_lines(const std::vector<SurfaceLine>& lines);

}  // namespace isoextract::cli
