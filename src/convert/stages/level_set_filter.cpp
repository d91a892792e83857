#include "convert/stages/level_set_filter.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/stopwatch.hpp"
#include "volume_io/grid_tools.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {

std::string text_of(const FilterStep& step) { return fmt::format("{}:{}", word_of(step.filter), step.reach); }

Result<void> filter_field(const std::vector<FilterStep>& steps, const std::string& label, const Context& context,
                          Events& events, field::ScalarField& field) {
  if (steps.empty()) return {};
  const bool is_sparse = std::holds_alternative<field::SparseSamples>(field.samples);
  if (field.kind != field::FieldKind::level_set || !is_sparse) {
    const char* found = field.kind != field::FieldKind::level_set ? "a density" : "dense samples";
    return fail(ErrorCode::input,
                fmt::format("{}: the filter needs the narrow band of a level set; found {}", label, found),
                {{Remedy::leave_out, Setting::level_set_filter,
                  "it works on a level set of a VDB file, or of particles as spheres or smooth"},
                 {Remedy::use, Setting::blur}});
  }
  for (const FilterStep& step : steps) {
    const Stopwatch watch;
    const field::SampleType before = field.type();
    auto filtered = TRY(volume_io::filter_level_set(field, step.filter, static_cast<int>(step.reach), 1, context));
    TRY(volume_io::check_mapping_intact(field));
    field = std::move(filtered);
    const auto& samples = std::get<field::SparseSamples>(field.samples);
    const std::string rounded =
        before == field.type() ? "" : fmt::format(", as {}", field::sample_type_name(field.type()));
    events.end(report_on_field(StageName::filter, label,
                               {WorkTopic::filter, WorkDone::filtered, samples.active_voxels, std::nullopt,
                                fmt::format("the level set by {}{}: {}", text_of(step), rounded,
                                            counted(samples.active_voxels, "active voxel"))},
                               watch.elapsed()));
    TRY(context.check());
  }
  return {};
}

}  // namespace isoextract::convert
