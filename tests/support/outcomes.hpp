// Finds the figures of a stage in an outcome.
#pragma once

#include <vector>

#include "convert/outcome.hpp"

namespace isoextract::test {

inline std::vector<convert::Figures> entries(const convert::Outcome& outcome, convert::StageName stage) {
  std::vector<convert::Figures> all;
  for (const convert::StageReport& report : outcome.reports) {
    if (report.stage == stage) all.insert(all.end(), report.entries.begin(), report.entries.end());
  }
  return all;
}

// Returns the figure of each surface or mesh that the stage reports.
template <class T>
std::vector<T> figures(const convert::Outcome& outcome, convert::StageName stage, convert::Key key) {
  std::vector<T> all;
  for (const convert::Figures& entry : entries(outcome, stage)) all.push_back(value_at<T>(entry, {key}).value_or(T()));
  return all;
}

}  // namespace isoextract::test
