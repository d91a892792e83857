#include "batch/frame_table.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/csv.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"

namespace isoextract::batch {
namespace {

using convert::Json;

template <class T>
std::string cell(const std::optional<T>& value) {
  if (!value) return {};
  if constexpr (std::is_same_v<T, bool>) return *value ? "1" : "0";
  return fmt::format("{}", *value);
}

bool has_figures(const FrameRow& row) {
  return row.status == FrameStatus::done || row.status == FrameStatus::empty || row.status == FrameStatus::kept;
}

}  // namespace

std::string output_of(const FrameRow& row, const SurfaceFigures* surface) {
  if (surface != nullptr && (!surface->output.empty() || surface->triangles == 0)) return surface->output;
  return row.outputs.empty() ? std::string() : row.outputs.front();
}

bool is_empty(const FrameFigures& figures) {
  return !figures.surfaces.empty() &&
         std::ranges::all_of(figures.surfaces, [](const SurfaceFigures& surface) { return surface.triangles == 0; });
}

std::string table_csv(std::span<const FrameRow> rows) {
  std::string text =
      "frame,input,output,status,iso,asked,triangles,vertices,area,volume,closed,components,seconds,memory,bytes,"
      "error,step,time,error_rms,error_max,coverage_rms,coverage_max,grid,lacked_attributes,unit\r\n";
  for (const FrameRow& row : rows) {
    const bool known = has_figures(row);
    const auto line = [&](const SurfaceFigures* surface) {
      const SurfaceFigures none;
      const SurfaceFigures& figures = surface != nullptr ? *surface : none;
      const std::vector<std::string> cells{
          fmt::format("{}", row.frame),
          csv_cell(row.input),
          csv_cell(output_of(row, surface)),
          std::string(
              word_of(surface != nullptr && known && surface->triangles == 0 ? FrameStatus::empty : row.status)),
          surface != nullptr ? figures.id.text() : std::string(),
          figures.asked,
          surface != nullptr ? fmt::format("{}", figures.triangles) : std::string(),
          cell(figures.vertices),
          cell(figures.area),
          cell(figures.volume),
          cell(figures.closed),
          cell(figures.components),
          known ? fmt::format("{:.6f}", row.figures.wall_seconds) : std::string(),
          known ? fmt::format("{}", row.figures.memory) : std::string(),
          surface != nullptr ? cell(figures.bytes) : cell(known ? std::optional(row.figures.bytes) : std::nullopt),
          csv_cell(row.error),
          cell(row.figures.time.step),
          cell(row.figures.time.time),
          cell(figures.error_rms),
          cell(figures.error_max),
          cell(figures.coverage_rms),
          cell(figures.coverage_max),
          csv_cell(figures.grid),
          csv_cell(fmt::format("{}", fmt::join(row.figures.lacked_attributes, " "))),
          csv_cell(row.figures.unit)};
      text += fmt::format("{}\r\n", fmt::join(cells, ","));
    };
    if (row.figures.surfaces.empty()) line(nullptr);
    for (const SurfaceFigures* surface : rows_of(row.figures)) line(surface);
  }
  return text;
}

Json row_json(const FrameRow& row) {
  Json surfaces = Json::array();
  for (const SurfaceFigures* figures : rows_of(row.figures)) {
    const SurfaceFigures& surface = *figures;
    surfaces.push_back({{"iso", json_of(surface.id)},
                        {"asked", surface.asked.empty() ? Json(nullptr) : Json(surface.asked)},
                        {"triangles", surface.triangles},
                        {"vertices", convert::optional_json(surface.vertices)},
                        {"area", convert::optional_json(surface.area)},
                        {"volume", convert::optional_json(surface.volume)},
                        {"closed", convert::optional_json(surface.closed)},
                        {"components", convert::optional_json(surface.components)},
                        {"output", surface.output.empty() ? Json(nullptr) : Json(surface.output)},
                        {"bytes", convert::optional_json(surface.bytes)},
                        {"error_rms", convert::optional_json(surface.error_rms)},
                        {"error_max", convert::optional_json(surface.error_max)},
                        {"coverage_rms", convert::optional_json(surface.coverage_rms)},
                        {"coverage_max", convert::optional_json(surface.coverage_max)},
                        {"grid", surface.grid.empty() ? Json(nullptr) : Json(surface.grid)}});
  }
  const bool known = has_figures(row);
  Json json{{"frame", row.frame},
            {"input", row.input},
            {"outputs", row.outputs},
            {"status", word_of(row.status)},
            {"surfaces", std::move(surfaces)},
            {"step", convert::optional_json(row.figures.time.step)},
            {"time", convert::optional_json(row.figures.time.time)},
            {"lacked_attributes", row.figures.lacked_attributes},
            {"unit", row.figures.unit.empty() ? Json(nullptr) : Json(row.figures.unit)},
            {"seconds", known ? Json(row.figures.wall_seconds) : Json(nullptr)},
            {"memory", known ? Json(row.figures.memory) : Json(nullptr)},
            {"bytes", known ? Json(row.figures.bytes) : Json(nullptr)},
            {"error", row.error.empty() ? Json(nullptr) : Json(row.error)}};
  if (row.rank) json["rank"] = *row.rank;
  return json;
}

Json table_json(std::span<const FrameRow> rows) {
  Json list = Json::array();
  for (const FrameRow& row : rows) {
    Json& entry = list.emplace_back(Json{{"schema", word_of(convert::JsonDocument::table)}});
    entry.update(row_json(row));
  }
  return list;
}

}  // namespace isoextract::batch
