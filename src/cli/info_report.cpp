#include "cli/info_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/byte_size.hpp"
#include "base/counted.hpp"
#include "base/number_text.hpp"
#include "base/printable.hpp"
#include "cli/layout.hpp"
#include "cli/remedies.hpp"
#include "convert/json_values.hpp"
#include "convert/placement.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::cli {
namespace {

constexpr std::size_t kHistogramRows = 16;
constexpr std::size_t kHistogramWidth = 40;
constexpr std::size_t kMaxName = 200;  // bytes shown of a name

std::string dims_text(const field::IndexBox& box) {
  if (box.empty()) return "no active voxels";
  const glm::i64vec3 dims = box.dims();
  return fmt::format("{} x {} x {}", dims.x, dims.y, dims.z);
}

glm::dvec3 spacing_of(const field::Affine& map) {
  return {glm::length(map.linear[0]), glm::length(map.linear[1]), glm::length(map.linear[2])};
}

// Returns ", 3 components, 12 volumes".
std::string several_text(const volume_io::GridInfo& grid) {
  std::string text;
  if (has_several_components(grid)) text += fmt::format(", {} components", grid.components);
  if (has_several_volumes(grid)) text += fmt::format(", {} volumes", grid.volumes);
  return text;
}

// Returns "; the plug-in for openvdb reads it", or why no reader does.
std::string reader_text(const volume_io::GridInfo& grid) {
  if (grid.plugin.empty()) {
    if (!grid.scalar) return "; isoextract cannot extract a surface from this type";
    return grid.placement_problem.empty() ? "" : "; its placement is not usable: " + grid.placement_problem;
  }
  if (grid.plugin_is_missing) return fmt::format("; needs the plug-in for {}, which is not installed", grid.plugin);
  return fmt::format("; the plug-in for {} reads it{}", grid.plugin,
                     grid.parts.empty() ? "" : fmt::format(" as {}", fmt::join(grid.parts, ", ")));
}

std::string component_text(const volume_io::ComponentChoice& choice) {
  return choice.number ? fmt::format("{}", *choice.number) : "the length of the vector";
}

void add_creator(NamedLines& lines, std::string_view creator) {
  if (creator.empty()) return;
  const auto up = convert::up_axis_of(creator);
  lines.add("creator", fmt::format("{}{}", printable(std::string(creator), kMaxName),
                                   up ? fmt::format("; {0} is the up axis: add --up {0}", word_of(*up)) : ""));
}

void add_grids(NamedLines& lines, const InputReport& report) {
  if (report.particles || (report.grids.size() <= 1 && report.field)) return;  // masks list no grids
  lines.add("grids", fmt::format("{}", report.grids.size()));
  std::size_t name_width = 4;
  for (const volume_io::GridInfo& grid : report.grids) name_width = std::max(name_width, grid.label.size());
  for (const volume_io::GridInfo& grid : report.grids) {
    lines.plain(fmt::format("    {:<{}}  {:<8}  {:<18}  {}{}{}{}", grid.label, name_width, grid.type,
                            grid.voxels ? dims_text(grid.box) : "unknown size",
                            grid.voxels ? counted(*grid.voxels, "active voxel") : "voxels not counted",
                            grid.kind ? fmt::format(", {}", convert::kind_name(*grid.kind)) : "", several_text(grid),
                            reader_text(grid)));
  }
  // The section about the field shows its creator.
  if (report.field || report.grids.empty()) return;
  const std::string& creator = report.grids.front().creator;
  if (std::ranges::all_of(report.grids, [&](const auto& grid) { return grid.creator == creator; })) {
    add_creator(lines, creator);
  }
}

void add_volumes(NamedLines& lines, const InputReport& report) {
  if (report.grids.size() != 1) return;  // the list of grids shows them
  for (const volume_io::GridInfo& grid : report.grids) {
    if (has_several_components(grid)) {
      lines.add(
          "components",
          fmt::format(
              "{}, counted from 0; this report describes {}, choose another with --component K or --component length",
              grid.components, component_text(report.component.value_or(volume_io::ComponentChoice{0}))));
    }
    if (!has_several_volumes(grid)) continue;
    lines.add("volumes", fmt::format("{}, counted from 0; this report describes {}, choose another with --volume K",
                                     grid.volumes, report.volume.value_or(0)));
    if (!grid.volume_times.empty()) {
      lines.add("times",
                fmt::format("{} to {} {}", grid.volume_times.front(), grid.volume_times.back(), grid.time_unit));
    }
  }
}

std::string hex_of(const glm::dvec3& color) {
  const auto channel = [](double value) { return static_cast<int>(std::lround(255 * std::clamp(value, 0.0, 1.0))); };
  return fmt::format("#{:02x}{:02x}{:02x}", channel(color.x), channel(color.y), channel(color.z));
}

// Lists the labels that the file names, unless the list of labels with voxels has their names.
void add_labels(NamedLines& lines, const InputReport& report) {
  constexpr std::size_t kMostShown = 64;
  const bool are_listed = report.grids.size() == 1 && report.field && report.field->labels;
  for (const volume_io::GridInfo& grid : report.grids) {
    const bool has_layers = std::ranges::any_of(grid.labels, [](const auto& label) { return label.layer.has_value(); });
    if (grid.labels.empty() || (are_listed && !has_layers)) continue;
    const std::string of_grid = report.grids.size() > 1 ? " of " + grid.label : "";
    const bool shows = grid.labels.size() <= kMostShown;
    lines.add("labels",
              fmt::format("{}{}{}", counted(grid.labels.size(), "name"), of_grid, shows ? "" : "; --json lists them"));
    for (std::size_t i = 0; shows && i < grid.labels.size(); ++i) {
      const field::LabelName& label = grid.labels[i];
      lines.plain(fmt::format("    {:>12}: {}{}{}", label.label, printable(label.name, kMaxName),
                              label.color ? ", " + hex_of(*label.color) : "",
                              label.layer ? fmt::format(", layer {}", *label.layer) : ""));
    }
  }
}

// Returns the least and greatest label if the samples are label ids that double cannot hold; nullopt otherwise.
std::optional<std::pair<std::int64_t, std::int64_t>> range_of_ids(const FieldReport& report) {
  if (!report.field.label_ids || !report.labels) return std::nullopt;
  std::int64_t least = report.labels->map.labels.front().label;
  std::int64_t most = report.labels->map.labels.back().label;
  if (report.labels->map.background) {
    least = std::min<std::int64_t>(least, 0);
    most = std::max<std::int64_t>(most, 0);
  }
  return std::pair(least, most);
}

// Returns the type of the samples as they were read: integers of 64 bits are f64, or i64 if they are ids of labels.
std::string_view type_name(const field::ScalarField& field) {
  return field.label_ids ? "i64" : field::sample_type_name(field.type());
}

void add_shape(NamedLines& lines, const FieldReport& report) {
  const field::ScalarField& field = report.field;
  lines.add("format", field.format);
  if (!field.name.empty()) lines.add("name", printable(field.name, kMaxName));
  add_creator(lines, field.creator);
  if (!report.labels) {
    lines.add("kind",
              fmt::format("{}: {} the iso value is inside", convert::kind_name(field.kind), word_of(field.kind)));
  }
  const field::IndexBox box = field.extents();
  if (const auto* sparse = std::get_if<field::SparseSamples>(&field.samples)) {
    lines.add(
        "samples",
        fmt::format("{}, sparse: {}; {} and {}; background {:.6g}", field::sample_type_name(sparse->type),
                    counted(sparse->active_voxels, "active voxel"), counted(sparse->blocks.size(), "stored block"),
                    counted(sparse->tiles.size(), "stored tile"), field.scale(sparse->background)));
    lines.add("extents", box.empty() ? dims_text(box)
                                     : fmt::format("{} from ({}, {}, {}) to ({}, {}, {})", dims_text(box), box.min.x,
                                                   box.min.y, box.min.z, box.max.x, box.max.y, box.max.z));
  } else {
    lines.add("samples", fmt::format("{}, dense", type_name(field)));
    lines.add("extents", dims_text(box));
  }
  if (!field.scale.is_identity()) {
    lines.add("scaling", fmt::format("value = {:.9g} * stored + {:.9g}", field.scale.slope, field.scale.intercept));
  }
  lines.add("spacing", vector_text(spacing_of(field.index_to_world)));
  if (!convert::is_axis_aligned(field.index_to_world)) {
    const glm::dvec3 spacing = spacing_of(field.index_to_world);
    for (int axis = 0; axis < 3; ++axis) {
      lines.add(axis == 0 ? "axes" : "", fmt::format("{} along ({})", "ijk"[axis],
                                                     vector_text(field.index_to_world.linear[axis] / spacing[axis])));
    }
  }
  lines.add("origin", vector_text(field.index_to_world.offset));
  if (!box.empty()) lines.add("world box", convert::box_text(convert::world_bounds(field)));
  if (!field.world_space.empty()) lines.add("world space", printable(field.world_space, kMaxName));
  if (!field.length_unit.empty()) {
    lines.add("unit", fmt::format("{}{}", printable(field.length_unit, kMaxName),
                                  convert::find_length_unit(field.length_unit) ? "; use it with --unit file" : ""));
  }
}

void add_histogram(NamedLines& lines, const field::FieldStatistics& statistics) {
  if (statistics.histogram.empty() || statistics.min == statistics.max) return;
  lines.add("histogram", "each row covers the values up to the next row; bars show the square root of the share");
  const std::size_t bins_a_row = statistics.histogram.size() / kHistogramRows;
  std::array<std::uint64_t, kHistogramRows> rows{};
  for (std::size_t i = 0; i < statistics.histogram.size(); ++i) rows[i / bins_a_row] += statistics.histogram[i];
  const double largest = std::sqrt(static_cast<double>(*std::max_element(rows.begin(), rows.end())));
  for (std::size_t row = 0; row < kHistogramRows; ++row) {
    const double position = static_cast<double>(row) / kHistogramRows;
    const double start = statistics.min * (1 - position) + statistics.max * position;
    const double share = std::sqrt(static_cast<double>(rows[row])) / largest;
    const auto length = static_cast<std::size_t>(std::ceil(share * kHistogramWidth));
    lines.plain(fmt::format("    {:>12.5g} {:<{}} {:6.2f} %", start, std::string(length, '#'), kHistogramWidth,
                            100.0 * static_cast<double>(rows[row]) / static_cast<double>(statistics.samples)));
  }
}

// Adds the distinct values of integer fields: labels, classes, masks.
void add_distinct(NamedLines& lines, const field::FieldStatistics& statistics) {
  constexpr std::size_t kMostShown = 64;
  constexpr std::size_t kInARow = 4;
  const std::size_t count = statistics.values.size();
  if (count == 0) return;
  const bool shows = count <= kMostShown;
  lines.add("distinct", fmt::format("{}{}", counted(count, "value"),
                                    shows ? ", with the number of samples of each" : "; --json lists them"));
  std::string row;
  for (std::size_t i = 0; shows && i < count; ++i) {
    const auto& [value, times] = statistics.values[i];
    row += fmt::format("{:>12.9g}: {:<12}", value, times);
    if ((i + 1) % kInARow != 0 && i + 1 != count) continue;
    row.erase(row.find_last_not_of(' ') + 1);
    lines.plain("    " + std::exchange(row, {}));
  }
}

void add_percentiles(NamedLines& lines, const field::FieldStatistics& statistics) {
  std::array<std::string, 2> percentiles;  // two lines
  for (std::size_t i = 0; i < statistics.percentiles.size(); ++i) {
    percentiles[i / 4] += fmt::format("{}{} %: {:.4g}", i % 4 == 0 ? "" : "   ", field::FieldStatistics::kPercents[i],
                                      statistics.percentiles[i]);
  }
  lines.add("percentiles", percentiles[0]);
  lines.add("", percentiles[1]);
}

void add_values(NamedLines& lines, const FieldReport& report) {
  const field::FieldStatistics& statistics = report.statistics;
  if (const auto ids = range_of_ids(report)) {
    lines.add("values", fmt::format("{} .. {}", ids->first, ids->second));
    return;
  }
  if (statistics.samples > 0) {
    lines.add("values", fmt::format("{:.6g} .. {:.6g}, mean {:.6g}", statistics.min, statistics.max, statistics.mean));
    if (!report.labels) add_percentiles(lines, statistics);
  } else if (statistics.nan + statistics.infinite == 0) {
    lines.add("values", "only the background");
  }
  if (statistics.nan + statistics.infinite > 0) {
    lines.add("not finite", fmt::format("{} NaN, {} infinite", statistics.nan, statistics.infinite));
  }
  if (report.labels) return;  // the list of labels replaces the histogram
  add_distinct(lines, statistics);
  add_histogram(lines, statistics);
}

constexpr std::string_view kCtMethod = "multi-Otsu: three classes of the histogram";

// Adds the triangles and memory of the suggested conversion, and the command.
void add_cost(NamedLines& lines, const FieldReport& report) {
  std::string cost =
      fmt::format("about {}; converting takes about {} of memory",
                  counted(convert::estimated_triangles(report.size), "triangle"), format_byte_size(report.bytes));
  if (report.whole_mesh_bytes > report.bytes) {
    cost += fmt::format(", {} with options that need the whole mesh", format_byte_size(report.whole_mesh_bytes));
  }
  lines.add("", cost);
  if (!report.fits_one_mesh) lines.add("", "the voxels lie too far apart for one mesh: extract regions with --roi");
  if (!report.command.empty()) lines.plain(fmt::format("\n  {}", report.command));
}

void add_advice(NamedLines& lines, const FieldReport& report) {
  lines.add("memory", fmt::format("{} of samples", format_byte_size(report.size.sample_bytes)));
  const field::IsoSuggestion& suggestion = report.suggestion;
  if (report.labels) {
    lines.add("suggestion", fmt::format("{}: {}", kAllLabels, surfaces_text(*report.labels)));
    add_cost(lines, report);
    return;
  }
  if (report.is_slice) {
    lines.add("suggestion",
              "--heightfield: terrain, if the samples are heights; one slice has no surface at an iso value");
    lines.plain(fmt::format("\n  {}", report.command));
    return;
  }
  if (report.statistics.samples == 0 && !suggestion.separates) return;
  if (!suggestion.separates) {
    const bool constant = report.statistics.min == report.statistics.max;
    lines.add("suggestion", constant ? std::string("none: the field is constant and has no surface")
                                     : fmt::format("none: no surface at {}, {}", suggestion.iso, suggestion.method));
    return;
  }
  if (report.ct) {
    lines.add("CT scan",
              fmt::format("--iso {}: skin; --iso {}: bone ({})", report.ct->skin, report.ct->bone, kCtMethod));
  }
  lines.add("suggestion", fmt::format("--iso {}: {}", suggestion.iso, suggestion.method));
  add_cost(lines, report);
}

convert::Json json_of(const volume_io::GridInfo& grid) {
  convert::Json json{{"name", grid.label},
                     {"type", grid.type},
                     {"scalar", grid.scalar || (!grid.plugin.empty() && !grid.plugin_is_missing)}};
  json["kind"] = grid.kind ? convert::Json(convert::kind_name(*grid.kind)) : nullptr;
  json["box"] = convert::json_of(grid.box);
  json["voxels"] = grid.voxels ? convert::Json(*grid.voxels) : nullptr;
  json["volumes"] = grid.volumes;
  json["components"] = grid.components;
  json["component_names"] = grid.component_names;
  json["times"] = grid.volume_times;
  json["time_unit"] = grid.time_unit;
  json["creator"] = grid.creator;
  json["labels"] = convert::Json::array();
  for (const field::LabelName& label : grid.labels) {
    convert::Json entry{{"label", label.label}, {"name", printable(label.name, kMaxName)}};
    entry["color"] = label.color ? convert::json_of(*label.color) : convert::Json(nullptr);
    entry["layer"] = label.layer ? convert::Json(*label.layer) : convert::Json(nullptr);
    json["labels"].push_back(std::move(entry));
  }
  const bool has_problem = !grid.placement_problem.empty() && !grid.is_readable();
  json["problem"] = has_problem ? convert::Json(grid.placement_problem) : convert::Json(nullptr);
  json["plugin"] = nullptr;
  if (!grid.plugin.empty()) {
    json["plugin"] = {{"id", grid.plugin}, {"is_there", !grid.plugin_is_missing}, {"grids", grid.parts}};
  }
  return json;
}

convert::Json json_of_values(const FieldReport& report) {
  const field::FieldStatistics& statistics = report.statistics;
  convert::Json json{{"finite", statistics.samples}, {"nan", statistics.nan}, {"infinite", statistics.infinite}};
  if (statistics.samples == 0) return json;
  if (const auto ids = range_of_ids(report)) {
    json["min"] = ids->first;
    json["max"] = ids->second;
    return json;
  }
  json["min"] = statistics.min;
  json["max"] = statistics.max;
  json["mean"] = statistics.mean;
  for (std::size_t i = 0; i < statistics.percentiles.size(); ++i) {
    json["percentiles"][std::to_string(field::FieldStatistics::kPercents[i])] = statistics.percentiles[i];
  }
  json["histogram"] = statistics.histogram;
  if (statistics.values.empty()) return json;
  json["distinct"] = convert::Json::array();
  for (const auto& [value, count] : statistics.values) json["distinct"].push_back({{"value", value}, {"count", count}});
  return json;
}

convert::Json json_of(const FieldReport& report) {
  const field::ScalarField& field = report.field;
  convert::Json json{{"format", field.format},
                     {"name", field.name},
                     {"kind", convert::kind_name(field.kind)},
                     {"inside", word_of(field.kind)},
                     {"type", type_name(field)}};
  const auto* sparse = std::get_if<field::SparseSamples>(&field.samples);
  json["sparse"] = sparse != nullptr;
  if (sparse != nullptr) {
    json["active_voxels"] = sparse->active_voxels;
    json["background"] = field.scale(sparse->background);
  }
  json["box"] = convert::json_of(field.extents());
  json["spacing"] = convert::json_of(spacing_of(field.index_to_world));
  json["index_to_world"] = convert::json_of(field.index_to_world);
  json["world_box"] = field.extents().empty() ? convert::Json(nullptr) : convert::json_of(convert::world_bounds(field));
  json["world_space"] = field.world_space;
  json["length_unit"] = field.length_unit;
  json["creator"] = field.creator;
  json["values"] = json_of_values(report);
  json["label_map"] = report.labels ? json_of(*report.labels, field) : convert::Json(nullptr);
  json["suggestion"] = nullptr;
  if (report.suggestion.separates || report.labels) {
    json["suggestion"] = {{"iso", report.suggestion.iso},
                          {"labels", nullptr},
                          {"method", report.suggestion.method},
                          {"triangles", convert::estimated_triangles(report.size)},
                          {"command", report.command}};
    if (report.labels) {
      json["suggestion"].update({{"iso", nullptr}, {"labels", "all"}, {"method", surfaces_text(*report.labels)}});
    }
  }
  json["ct"] = nullptr;
  if (report.ct) json["ct"] = {{"skin", report.ct->skin}, {"bone", report.ct->bone}, {"method", kCtMethod}};
  json["memory"] = {
      {"samples", report.size.sample_bytes}, {"conversion", report.bytes}, {"whole_mesh", report.whole_mesh_bytes}};
  json["notes"] = convert::json_of_notes(field.notes);
  return json;
}

// Returns whether the user has to choose one of several grids, or one component of a vector grid.
bool has_choice(std::span<const volume_io::GridInfo> grids) {
  return grid_without_choice(grids) == nullptr && std::ranges::any_of(grids, &volume_io::GridInfo::is_readable);
}

}  // namespace

const volume_io::GridInfo* grid_without_choice(std::span<const volume_io::GridInfo> grids) {
  // Chooses as read_volume does: the only scalar grid, or if there is none, the only one that a plug-in can convert.
  const auto scalars = std::ranges::count(grids, true, &volume_io::GridInfo::scalar);
  const volume_io::GridInfo* found = nullptr;
  for (const volume_io::GridInfo& grid : grids) {
    const bool counts = scalars > 0 ? grid.scalar : grid.is_readable();
    if (!counts) continue;
    if (found != nullptr || grid.parts.size() > 1) return nullptr;
    found = &grid;
  }
  return found;
}

bool has_several_volumes(const volume_io::GridInfo& grid) { return grid.volumes > 1; }
bool has_several_components(const volume_io::GridInfo& grid) { return grid.components > 1; }

std::string text_of(const InputReport& report) {
  NamedLines lines;
  lines.plain(printable(files::input_label(report.input)));
  add_grids(lines, report);
  add_volumes(lines, report);
  add_labels(lines, report);
  if (report.particles) {
    add_particles(lines, *report.particles);
    if (report.field) {
      add_creator(lines, report.field->field.creator);
      add_advice(lines, *report.field);
    }
  } else if (report.field) {
    add_shape(lines, *report.field);
    if (report.field->labels) add_label_map(lines, *report.field->labels, report.field->field);
    add_values(lines, *report.field);
    add_advice(lines, *report.field);
  } else if (has_choice(report.grids)) {
    lines.plain("  choose one grid with --grid NAME");
  }
  return lines.take();
}

convert::Json json_of(const InputReport& report) {
  convert::Json json{{"input", report.input}};
  json["grids"] = convert::Json::array();
  for (const volume_io::GridInfo& grid : report.grids) json["grids"].push_back(json_of(grid));
  json["volume"] = report.volume ? convert::Json(*report.volume) : convert::Json(nullptr);
  json["component"] = nullptr;
  if (report.component)
    json["component"] = report.component->number ? convert::Json(*report.component->number) : "length";
  json["particles"] = report.particles ? json_of(*report.particles) : convert::Json(nullptr);
  json["field"] = report.field ? json_of(*report.field) : convert::Json(nullptr);
  if (report.error) json["error"] = {{"message", report.error->message}, {"hint", hint_text(report.error->hint)}};
  return json;
}

}  // namespace isoextract::cli
