#include "convert/detail/several_grids.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "convert/particle_source.hpp"
#include "files/file_bytes.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {
namespace {

bool has_surfaces_of(const OutputFileJob& output, const std::optional<std::string>& grid) {
  return !output.grid || output.grid == grid;
}

}  // namespace

std::vector<std::optional<std::string>> grids_of(const SourceOptions& source) {
  std::vector<std::optional<std::string>> grids{source.read.grid};
  grids.insert(grids.end(), source.more_grids.begin(), source.more_grids.end());
  return grids;
}

std::vector<std::optional<std::string>> grids_of(const SourceOptions& source, const OutputFileJob& output) {
  if (output.grid) return {output.grid};
  return grids_of(source);
}

SourceOptions with_grid(const SourceOptions& source, const std::optional<std::string>& grid) {
  SourceOptions options = source;
  options.read.grid = grid;
  return options;
}

std::vector<IsoChoice> isos_of(const ConversionJob& job, const std::optional<std::string>& grid) {
  std::vector<IsoChoice> isos;
  for (const OutputFileJob& output : job.outputs) {
    if (has_surfaces_of(output, grid)) isos.insert(isos.end(), output.isos.begin(), output.isos.end());
  }
  return isos;
}

std::size_t first_iso_of(const ConversionJob& job, std::size_t output, const std::optional<std::string>& grid) {
  std::size_t first = 0;
  for (std::size_t o = 0; o < output; ++o) {
    if (has_surfaces_of(job.outputs[o], grid)) first += job.outputs[o].isos.size();
  }
  return first;
}

Result<std::vector<std::optional<std::int64_t>>> volumes_of(const SourceOptions& source,
                                                            const std::vector<IsoChoice>& isos,
                                                            const Context& context) {
  std::vector<std::optional<std::int64_t>> volumes{source.read.volume};
  if (isos.empty() || !std::ranges::all_of(isos, &IsoChoice::is_label) || source.read.volume) return volumes;
  const auto particles = TRY(is_particles(source, context));
  if (particles) return volumes;
  const auto grids = TRY(volume_io::list_grids(source.input, source.read, context));
  std::set<std::uint64_t> layers;
  for (const volume_io::GridInfo& grid : grids) {
    if (source.read.grid && !grid.matches_name(*source.read.grid)) continue;
    for (const field::LabelName& label : grid.labels) {
      if (label.layer) layers.insert(*label.layer);
    }
  }
  if (layers.empty()) return volumes;
  return std::vector<std::optional<std::int64_t>>(layers.begin(), layers.end());
}

std::optional<extract::LabelChoice> chosen_labels(std::span<const ResolvedIso> isos, std::int64_t background) {
  extract::LabelChoice choice;
  choice.background = background;
  for (const ResolvedIso& iso : isos) {
    if (!iso.asked.is_label()) return std::nullopt;
    choice.all = choice.all || !iso.id.is_label();
    if (iso.id.is_label()) choice.values.push_back(iso.id.label());
  }
  return isos.empty() ? std::nullopt : std::optional(choice);
}

std::vector<ResolvedIso> surfaces_of(const field::ScalarField& field, std::span<const ResolvedIso> asked,
                                     const std::vector<std::int64_t>* labels, std::optional<std::int64_t> layer) {
  if (labels == nullptr) return without_repeats(asked);
  std::vector<ResolvedIso> surfaces = expand_labels(asked, *labels);
  const bool is_list = std::ranges::all_of(asked, [](const ResolvedIso& iso) { return iso.id.is_label(); });
  if (!layer || !is_list) return surfaces;
  std::optional<std::int64_t> first;
  std::unordered_map<std::int64_t, bool> named_here;  // for each label with a name: whether it is in this layer
  for (const field::LabelName& label : field.labels) {
    if (label.layer) first = std::min(first.value_or(*label.layer), *label.layer);
    named_here[label.label] |= label.layer == layer;
  }
  std::erase_if(surfaces, [&](const ResolvedIso& iso) {
    const auto named = named_here.find(iso.id.label());
    return named != named_here.end() ? !named->second : first != layer;
  });
  return surfaces;
}

Result<void> check_grids(const SourceOptions& source, const Context& context) {
  if (source.more_grids.empty()) return {};
  std::vector<std::string> labels;
  for (const std::optional<std::string>& grid : grids_of(source)) {
    const SourceOptions options = with_grid(source, grid);
    const auto particles = TRY(is_particles(options, context));
    if (particles) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected only volumes in a run with several grids, found particles in '{}'",
                              files::input_label(source.input), printable(grid.value_or(""))),
                  "convert the particles in a separate run");
    }
    auto label = TRY(volume_io::grid_label(source.input, options.read, context));
    if (std::ranges::find(labels, label) != labels.end()) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected each grid once, found '{}' twice", files::input_label(source.input), label),
                  "choose each grid once");
    }
    labels.push_back(std::move(label));
  }
  return {};
}

}  // namespace isoextract::convert
