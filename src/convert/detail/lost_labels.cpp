#include "convert/detail/lost_labels.hpp"

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"
#include "convert/field_label.hpp"
#include "convert/stage_report.hpp"
#include "field/distinct_values.hpp"

namespace isoextract::convert {

void tell_lost_labels(const field::ScalarField& map, const field::ScalarField& grid, std::int64_t background,
                      const Context& context, Events& events) {
  const auto labels_of = [&](const field::ScalarField& field) {
    std::vector<std::int64_t> ids;
    for (const double value : field::distinct_values(field, &context.progress())) {
      const auto sample = static_cast<std::int64_t>(value);
      ids.push_back(field.label_ids != nullptr ? (*field.label_ids)[static_cast<std::size_t>(sample)] : sample);
    }
    std::erase(ids, background);
    std::ranges::sort(ids);
    return ids;
  };
  const std::vector<std::int64_t> labels = labels_of(map);
  const std::vector<std::int64_t> left = labels_of(grid);
  std::vector<std::int64_t> lost;
  std::ranges::set_difference(labels, left, std::back_inserter(lost));
  if (lost.empty()) return;
  constexpr std::size_t kMostTold = 10;
  const std::span<const std::int64_t> told = std::span(lost).first(std::min(lost.size(), kMostTold));
  const std::string ids = fmt::format("{}{}", fmt::join(told, ", "), lost.size() > kMostTold ? ", ..." : "");
  events.note(
      {NoteId::labels_lost, fmt::format("{}: no mesh for {} of {} ({}): the coarser grid has no sample of these labels",
                                        field_label(map), lost.size(), counted(labels.size(), "label"), ids)});
  StageReport report = report_on(StageName::resample, field_label(map));
  report.work.push_back({WorkTopic::labels, WorkDone::left_out, lost.size(), labels.size(),
                         fmt::format("{} of {}, because the coarser grid has no sample of these labels: {}",
                                     lost.size(), counted(labels.size(), "label"), ids)});
  events.end(report);
}

}  // namespace isoextract::convert
