#include "cli/label_report.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"
#include "base/printable.hpp"
#include "cli/voxel_plan.hpp"
#include "convert/json_values.hpp"
#include "convert/placement.hpp"

namespace isoextract::cli {
namespace {

constexpr std::size_t kMostShown = 20;     // labels in the text
constexpr std::size_t kMaxLabelName = 60;  // bytes shown of a name

// Returns the world bounds of the voxel centers (not of the voxels), as the report does for the whole field.
field::Box world_box_of(const field::LabelFigures& label, const field::ScalarField& field) {
  return field::image_of(field.index_to_world, {glm::dvec3(label.box.min), glm::dvec3(label.box.max)});
}

double volume_of(const field::LabelFigures& label, const field::ScalarField& field) {
  return static_cast<double>(label.voxels) * std::abs(field.index_to_world.determinant());
}

// Returns "binary mask: 0 and 255", "label map: 3 labels, background 0".
std::string content_text(const LabelReport& report) {
  const std::vector<field::LabelFigures>& labels = report.map.labels;
  if (report.layers > 0) {
    return fmt::format("masks: {} with voxels, in {}", labels.size(), counted(report.layers, "layer"));
  }
  if (report.map.kind == field::LabelMapKind::binary_mask) {
    return report.map.background ? fmt::format("binary mask: 0 and {}", labels.front().label)
           : labels.size() > 1   ? fmt::format("binary mask: {} and {}", labels.front().label, labels.back().label)
                                 : fmt::format("binary mask: {} in the background", labels.front().label);
  }
  return fmt::format("label map: {}, {}; {:.0f} % of the neighbors in labels are equal",
                     counted(labels.size(), "label"), report.map.background ? "background 0" : "without the label 0",
                     100 * report.map.equal_share);
}

std::vector<std::string> names_without_voxels(const LabelReport& report) {
  std::vector<std::string> names;
  for (const field::LabelName& name : report.names) {
    const bool is_found = std::ranges::binary_search(report.map.labels, name.label, {}, &field::LabelFigures::label);
    if (name.label != 0 && !is_found) names.push_back(printable(name.name, kMaxLabelName));
  }
  return names;
}

// Adds one row for each of the first labels, in columns.
void add_rows(NamedLines& lines, const LabelReport& report, const field::ScalarField& field) {
  struct Row {
    std::string volume;
    std::string box;
    std::string world_box;
  };
  const std::span<const field::LabelFigures> labels =
      std::span(report.map.labels).first(std::min(report.map.labels.size(), kMostShown));
  std::vector<Row> rows;
  Row widest;
  std::size_t label_width = 8;
  for (const field::LabelFigures& label : labels) {
    label_width = std::max(label_width, fmt::formatted_size("{}", label.label));
    const glm::ivec3& low = label.box.min;
    const glm::ivec3& high = label.box.max;
    Row& row = rows.emplace_back(Row{
        fmt::format("{:.6g}", volume_of(label, field)),
        fmt::format("({}, {}, {}) .. ({}, {}, {})", low.x, low.y, low.z, high.x, high.y, high.z),
        convert::box_text(world_box_of(label, field)),
    });
    for (std::string Row::*const text : {&Row::volume, &Row::box, &Row::world_box}) {
      if ((row.*text).size() > (widest.*text).size()) widest.*text = row.*text;
    }
  }
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const field::LabelName* name = report.find(labels[n].label);
    std::string line =
        fmt::format("    {:>{}}: {:>9}  {:>{}}  {:<{}}  {:<{}}  {}", labels[n].label, label_width, labels[n].voxels,
                    rows[n].volume, widest.volume.size(), rows[n].box, widest.box.size(), rows[n].world_box,
                    widest.world_box.size(), name != nullptr ? printable(name->name, kMaxLabelName) : "");
    line.erase(line.find_last_not_of(' ') + 1);
    lines.plain(line);
  }
}

convert::Json json_of(const field::LabelFigures& label, const field::ScalarField& field) {
  return {{"label", label.label},
          {"voxels", label.voxels},
          {"volume", volume_of(label, field)},
          {"box", convert::json_of(label.box)},
          {"world_box", convert::json_of(world_box_of(label, field))}};
}

}  // namespace

const field::LabelName* LabelReport::find(std::int64_t label) const {
  const auto found = std::ranges::lower_bound(names, label, {}, &field::LabelName::label);
  return found != names.end() && found->label == label ? &*found : nullptr;
}

std::optional<LabelReport> report_labels(const std::string& input, std::optional<std::int64_t> volume,
                                         const Context& context, field::ScalarField& field) {
  auto map = field::measure_label_map(field, &context.progress());
  if (!map) return std::nullopt;
  LabelReport report{.map = std::move(*map), .names = {}, .table = {}};
  const auto is_here = [&](const field::LabelName& name) { return !name.layer || name.layer == volume.value_or(0); };
  std::ranges::copy_if(field.labels, std::back_inserter(report.names), is_here);
  if (!field.labels.empty()) return report;
  if (auto found = read_table_beside(input, context, field.notes)) {
    report.names = found->table.entries();
    report.table = std::move(found->path);
  }
  return report;
}

std::optional<LabelReport> report_masks(const convert::MaskLayers& masks) {
  if (masks.figures().empty()) return std::nullopt;
  LabelReport report{.map = {}, .names = masks.names(), .layers = masks.layers().size(), .table = {}};
  report.map.labels = masks.figures();
  report.map.faces = masks.faces();
  return report;
}

void add_label_map(NamedLines& lines, const LabelReport& report, const field::ScalarField& field) {
  lines.add("content", content_text(report));
  if (!report.table.empty()) lines.add("names", fmt::format("from {}", printable(report.table)));
  const std::vector<field::LabelFigures>& labels = report.map.labels;
  const std::string unit = field.length_unit.empty() ? "" : printable(field.length_unit, kMaxLabelName) + "^3";
  const std::string shown = labels.size() > kMostShown
                                ? fmt::format(" of the first {} of {}; --json lists all", kMostShown, labels.size())
                                : "";
  lines.add("labels", fmt::format("voxels, volume{}{}, box of indices, box in the world{}", unit.empty() ? "" : " in ",
                                  unit, shown));
  add_rows(lines, report, field);
  const std::vector<std::string> unused = names_without_voxels(report);
  // Skips unused names of a label table, because a table may serve several maps.
  if (unused.empty() || !report.table.empty()) return;
  const std::size_t told = std::min(unused.size(), kMostShown);
  lines.add("no voxels",
            fmt::format("{}{}", fmt::join(unused.begin(), unused.begin() + static_cast<std::ptrdiff_t>(told), ", "),
                        told < unused.size() ? ", ..." : ""));
}

std::string surfaces_text(const LabelReport& report) {
  return report.map.labels.size() == 1 ? "a smooth closed mesh of the mask"
                                       : "a smooth closed mesh of each label, without gaps between them";
}

convert::Json json_of(const LabelReport& report, const field::ScalarField& field) {
  convert::Json json{{"kind", word_of(report.map.kind)}};
  json["equal_neighbors"] = report.layers > 0 ? convert::Json(nullptr) : convert::Json(report.map.equal_share);
  json["background"] = report.map.background ? json_of(*report.map.background, field) : convert::Json(nullptr);
  json["names_from"] = report.table.empty() ? convert::Json(nullptr) : convert::Json(report.table);
  json["labels"] = convert::Json::array();
  for (const field::LabelFigures& label : report.map.labels) {
    convert::Json& entry = json["labels"].emplace_back(json_of(label, field));
    const field::LabelName* name = report.find(label.label);
    entry["name"] = name != nullptr ? convert::Json(printable(name->name)) : convert::Json(nullptr);
    entry["color"] = name != nullptr && name->color ? convert::json_of(*name->color) : convert::Json(nullptr);
  }
  return json;
}

}  // namespace isoextract::cli
