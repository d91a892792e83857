// Formats the times of stages. --verbose prints them: a line for each stage, and one for a stage of several labels.
#pragma once

#include <cstddef>
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
    std::size_t labels = 0;
    double seconds = 0;              // wall time, summed over the labels
    std::vector<std::string> first;  // lines of the first label
  };

  std::vector<Stage> stages_;
};

}  // namespace isoextract::cli
