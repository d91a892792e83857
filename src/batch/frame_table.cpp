#include "batch/frame_table.hpp"

#include <optional>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::batch {
namespace {

using convert::Json;

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + '"';
}

template <class T>
std::string cell(const std::optional<T>& value) {
  if (!value) return {};
  if constexpr (std::is_same_v<T, bool>) return *value ? "1" : "0";
  return fmt::format("{}", *value);
}

bool has_figures(const FrameRow& row) { return row.status == FrameStatus::done || row.status == FrameStatus::kept; }

}  // namespace

std::string table_csv(std::span<const FrameRow> rows) {
  std::string text =
      "frame,input,output,status,iso,asked,triangles,vertices,area,volume,closed,components,seconds,memory,bytes,"
      "error\r\n";
  for (const FrameRow& row : rows) {
    const auto line = [&](const SurfaceFigures* surface) {
      std::vector<std::string> cells{fmt::format("{}", row.frame), quoted(row.input),
                                     row.outputs.empty() ? std::string() : quoted(row.outputs.front()),
                                     std::string(word_of(row.status))};
      if (surface != nullptr) {
        cells.insert(cells.end(), {fmt::format("{}", surface->iso), surface->asked,
                                   fmt::format("{}", surface->triangles), cell(surface->vertices), cell(surface->area),
                                   cell(surface->volume), cell(surface->closed), cell(surface->components)});
      } else {
        cells.insert(cells.end(), 8, std::string());
      }
      if (has_figures(row)) {
        cells.insert(cells.end(), {fmt::format("{:.6f}", row.figures.wall_seconds),
                                   fmt::format("{}", row.figures.memory), fmt::format("{}", row.figures.bytes)});
      } else {
        cells.insert(cells.end(), 3, std::string());
      }
      cells.push_back(quoted(row.error));
      text += fmt::format("{}\r\n", fmt::join(cells, ","));
    };
    if (row.figures.surfaces.empty()) line(nullptr);
    for (const SurfaceFigures& surface : row.figures.surfaces) line(&surface);
  }
  return text;
}

Json table_json(std::span<const FrameRow> rows) {
  Json list = Json::array();
  for (const FrameRow& row : rows) {
    Json surfaces = Json::array();
    for (const SurfaceFigures& surface : row.figures.surfaces) {
      surfaces.push_back({{"iso", surface.iso},
                          {"asked", surface.asked.empty() ? Json(nullptr) : Json(surface.asked)},
                          {"triangles", surface.triangles},
                          {"vertices", convert::optional_json(surface.vertices)},
                          {"area", convert::optional_json(surface.area)},
                          {"volume", convert::optional_json(surface.volume)},
                          {"closed", convert::optional_json(surface.closed)},
                          {"components", convert::optional_json(surface.components)}});
    }
    const bool known = has_figures(row);
    list.push_back({{"frame", row.frame},
                    {"input", row.input},
                    {"outputs", row.outputs},
                    {"status", word_of(row.status)},
                    {"surfaces", std::move(surfaces)},
                    {"seconds", known ? Json(row.figures.wall_seconds) : Json(nullptr)},
                    {"memory", known ? Json(row.figures.memory) : Json(nullptr)},
                    {"bytes", known ? Json(row.figures.bytes) : Json(nullptr)},
                    {"error", row.error.empty() ? Json(nullptr) : Json(row.error)}});
  }
  return list;
}

}  // namespace isoextract::batch
