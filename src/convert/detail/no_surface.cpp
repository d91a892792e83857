#include "convert/detail/no_surface.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "convert/output_checks.hpp"
#include "field/statistics.hpp"
#include "files/output_file.hpp"

namespace isoextract::convert {
namespace {

Hint or_allow_empty(Step step) { return {std::move(step), {Remedy::use, Setting::empty_policy}}; }

}  // namespace

Error empty_source(const Source& source) {
  return {ErrorCode::empty_grid, fmt::format("{}: {}", source.label, source.why_empty()),
          source.region_is_empty
              ? or_allow_empty({Remedy::check, Setting::region, "the region is in the coordinates of the file"})
              : Hint(Remedy::use, Setting::empty_policy)};
}

Result<void> leave_out_empty(const Source& source, const ConversionJob& job, const OutputFileJob& output,
                             const Context& context, Events& events) {
  if (job.empty == EmptyPolicy::error) return tl::unexpected(empty_source(source));
  const auto removed = TRY(remove_old_meshes(output, job.meshes().format, context));
  events.note({NoteId::no_surface,
               fmt::format("{}: {}; the conversion did not write {}{}", source.label, source.why_empty(),
                           files::output_label(output.path), removed.empty() ? "" : " and removed the old file")});
  return {};
}

Error no_label(const Source& source, std::int64_t background, const LabelCounts& labels) {
  if (source.empty) return empty_source(source);
  if (labels.too_small > 0) {
    return {ErrorCode::no_surface,
            fmt::format("{}: {} chosen, none with as many voxels as required", source.label,
                        counted(labels.too_small, "label")),
            {Remedy::use, Setting::empty_policy}};
  }
  if (labels.found == 0) {
    return {ErrorCode::no_surface,
            fmt::format("{}: no sample has a label other than {}", source.label, background),
            {Remedy::use, Setting::empty_policy}};
  }
  return {
      ErrorCode::no_surface,
      fmt::format("{}: the choice includes none of the {} in the file", source.label, counted(labels.found, "label")),
      {Remedy::use, Setting::empty_policy}};
}

Note note_of_no_label(const Error& none, const OutputFileJob& output, const std::string& besides) {
  return {NoteId::no_surface, fmt::format("{}; the conversion did not write {}{}", none.message,
                                          files::output_label(output.path), besides)};
}

Error no_surface(const ConversionJob& job, const Source& source, const ResolvedIso& asked, bool are_labels,
                 const std::optional<mesh::Bounds>& cut_away) {
  if (source.empty) return empty_source(source);
  if (cut_away) {
    const field::Affine given_from_output =
        request_from_index(source.field, job.source.placement.space).after(source.output_from_index.inverse());
    return {
        ErrorCode::no_surface,
        fmt::format("{}: clipping removes the whole surface{}; the surface lies in {}", source.label, place_text(asked),
                    box_text(field::image_of(given_from_output, {cut_away->min, cut_away->max}))),
        or_allow_empty(job.source.clip.empty() ? Step(Remedy::raise, Setting::region)
                                               : Step(Remedy::check, Setting::clip,
                                                      "a plane keeps the points with NX x + NY y + NZ z >= D"))};
  }
  if (are_labels) {
    return {ErrorCode::no_surface,
            fmt::format("{}: no sample has {}", source.label, text_of(asked)),
            {Remedy::use, Setting::empty_policy}};
  }
  if (job.surface.heights) {
    return {ErrorCode::no_surface,
            fmt::format("{}: there is no terrain: every square of four samples has a NaN sample", source.label),
            {Remedy::use, Setting::empty_policy}};
  }
  const auto* dense = std::get_if<field::DenseSamples>(&source.field.samples);
  if (dense != nullptr && dense->layers != nullptr) {  // statistics need all samples
    return {
        ErrorCode::no_surface,
        fmt::format("{}: no surface at iso {}{}", source.label, text_of(asked), source.region ? " in the region" : ""),
        {Remedy::use, Setting::empty_policy}};
  }
  const field::FieldStatistics statistics = field::measure_statistics(source.field);
  const auto passed = field::surface_range(source.field, statistics);
  if (!passed || (statistics.samples == 0 && !statistics.far_inside)) {
    // Active voxels that have the background value are not stored, so statistics can be empty without NaN samples.
    const bool all_alike = statistics.nan == 0 && statistics.infinite == 0;
    return {ErrorCode::no_surface,
            fmt::format("{}: there is no surface: {}", source.label,
                        all_alike ? "every voxel has the background value" : "no sample is a finite number"),
            {Remedy::use, Setting::empty_policy}};
  }
  const double iso = asked.id.iso();
  const bool region_hides_it = source.region && passed->has_surface(iso);
  const double min = statistics.samples > 0 ? statistics.min : passed->min;
  const double max = statistics.samples > 0 ? statistics.max : passed->max;
  const field::IsoSuggestion suggestion = field::suggest_iso(source.field, statistics);
  const Step other =
      suggestion.separates
          ? Step(Remedy::try_value, Setting::iso, fmt::format("{} ({})", suggestion.iso, suggestion.method))
          : Step("try another input: no iso value separates these samples into two groups");
  return {ErrorCode::no_surface,
          fmt::format("{}: no surface at iso {}{}{}; the values {}range from {:.6g} to {:.6g}", source.label,
                      text_of(asked), source.region ? " in the region" : "",
                      job.source.resamples() ? " after resampling" : "", source.region ? "of the whole field " : "",
                      min, max),
          or_allow_empty(region_hides_it ? Step(Remedy::raise, Setting::region) : other)};
}

}  // namespace isoextract::convert
