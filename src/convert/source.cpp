#include "convert/source.hpp"

#include <utility>

#include "convert/field_label.hpp"
#include "field/resample.hpp"

namespace isoextract::convert {
namespace {

// The grid of another resolution takes the place of the data.
Result<void> change_resolution(const SourceOptions& options, bool keep_data, const Context& context, Events& events,
                               Source& source) {
  const Stopwatch watch;
  auto grid = field::resample(source.field, *options.resolution, context);
  if (!grid) return tl::unexpected(std::move(grid.error()));
  const StageTime time = watch.elapsed();
  for (const std::string& text : grid->notes) events.note(text);
  events.resampled(*grid, resolution_fact(source.field, *grid), time);
  if (keep_data) source.data = std::move(source.field);
  source.field = std::move(*grid);
  return context.check();
}

}  // namespace

Result<field::ScalarField> read_field(const std::string& input, const volumes::ReadOptions& options,
                                      const Context& context, Events& events) {
  const Stopwatch watch;
  auto field = volumes::read_volume(input, options, context);
  if (!field) return field;
  const StageTime time = watch.elapsed();
  for (const std::string& text : field->notes) events.note(text);
  events.read(input, *field, time);
  if (auto go_on = context.check(); !go_on) return tl::unexpected(std::move(go_on.error()));
  if (auto whole = volumes::check_not_lost(*field); !whole) return tl::unexpected(std::move(whole.error()));
  return field;
}

extract::ExtractOptions Source::extract_options(const SurfaceOptions& surface, double iso) const {
  extract::ExtractOptions options;
  options.method = surface.method;
  options.nan = surface.nan;
  options.cap = surface.cap;
  options.iso = iso;
  options.region = region;
  options.output_from_index = output_from_index;
  return options;
}

Result<Source> open_source(const SourceOptions& options, bool keep_data, const Context& context, Events& events) {
  auto field = read_field(options.input, options.read, context, events);
  if (!field) return tl::unexpected(std::move(field.error()));
  Source source;
  source.label = field_label(*field);
  const auto* sparse = std::get_if<field::SparseSamples>(&field->samples);
  source.empty = sparse != nullptr && sparse->blocks.empty() && sparse->tiles.empty() && sparse->active_voxels == 0;
  source.field = std::move(*field);
  for (const WorkFact& fact : reading_facts(source.field)) events.worked(fact);
  if (options.resolution) {
    auto changed = change_resolution(options, keep_data, context, events, source);
    if (!changed) return tl::unexpected(std::move(changed.error()));
  }
  auto placed = place_field(source.field, options.placement, options.roi);
  if (!placed) return tl::unexpected(std::move(placed.error()));
  events.placed(*placed);
  for (const std::string& text : placed->notes) events.note(text);
  source.output_from_index = placed->output_from_index;
  source.region = placed->region;
  return source;
}

}  // namespace isoextract::convert
