#include "cli/bench_report.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/byte_size.hpp"
#include "base/counted.hpp"
#include "base/csv.hpp"
#include "base/machine.hpp"
#include "base/printable.hpp"
#include "base/version.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"

namespace isoextract::cli {
namespace {

std::string milliseconds(double seconds) { return fmt::format("{:.3g}", 1e3 * seconds); }

std::string angle_text(const std::optional<accuracy::AngleStatistics>& angles) {
  return angles ? fmt::format("{:.3g}", angles->rms_degrees) : "-";
}

std::string percent_text(const std::optional<double>& error) {
  return error ? fmt::format("{:.2g}", 100 * *error) : "-";
}

std::string order_text(const std::optional<bench::ConvergenceOrder>& order) {
  return order ? fmt::format("{:.2f} ({:.2f})", order->slope, order->last) : "-";
}

std::string setting_text(const bench::BenchResult& result, const bench::BenchRow& row) {
  return fmt::format("{} {} {}, {}", word_of(row.method), row.backend, result.levels[row.level].size,
                     counted(row.threads, "thread"));
}

std::uint64_t unmeasured_points(const bench::BenchResult& result) {
  std::uint64_t most = 0;
  for (const bench::BenchRow& row : result.rows) {
    if (row.position) most = std::max(most, row.position->unmeasured());
  }
  return most;
}

// Returns the lines of the Pareto front; empty if no errors were measured.
std::string front_text(const bench::BenchResult& result) {
  std::vector<const bench::BenchRow*> front;
  for (const bench::BenchRow& row : result.rows) {
    if (row.on_front) front.push_back(&row);
  }
  if (front.empty()) return "";
  std::ranges::sort(front, {}, &bench::BenchRow::median_seconds);
  std::string text = "Rows that no other row beats in both error and time (*):\n";
  for (const bench::BenchRow* row : front) {
    text += fmt::format("  {}: {} ms, rms {:.3g}\n", setting_text(result, *row), milliseconds(row->median_seconds),
                        row->position->rms.world);
  }
  return text;
}

std::string orders_text(const bench::BenchResult& result) {
  std::vector<std::vector<std::string>> orders{
      {"method", "backend", "position", "smooth normals", "flat normals", "area", "volume"}};
  for (const bench::BenchOrders& order : result.orders) {
    orders.push_back({std::string(word_of(order.method)), order.backend, order_text(order.position),
                      order_text(order.smooth_normals), order_text(order.flat_normals), order_text(order.area),
                      order_text(order.volume)});
  }
  return "Orders of convergence, error ~ spacing^order: slope over all sizes (between the last two)\n" +
         aligned_table(orders, 2);
}

convert::Json json_or_null(const std::optional<double>& value) {
  return value ? convert::Json(*value) : convert::Json(nullptr);
}

convert::Json json_of(const std::optional<accuracy::AngleStatistics>& angles) {
  if (!angles) return nullptr;
  return {{"rms_degrees", angles->rms_degrees}, {"max_degrees", angles->max_degrees}};
}

convert::Json json_of(const std::optional<bench::ConvergenceOrder>& order) {
  if (!order) return nullptr;
  return {{"slope", order->slope}, {"last", order->last}};
}

convert::Json json_of(const accuracy::Length& length) { return {{"voxels", length.voxels}, {"world", length.world}}; }

convert::Json json_of_position(const bench::BenchRow& row) {
  if (!row.position) return nullptr;
  return {{"rms", json_of(row.position->rms)}, {"percentile99", json_of(row.position->percentile99)},
          {"max", json_of(row.position->max)}, {"worst", convert::json_of(row.position->worst)},
          {"rounding", row.rounding},          {"unmeasured", row.position->unmeasured()}};
}

convert::Json json_of(const std::optional<bench::BenchDeviceTimes>& device) {
  if (!device) return nullptr;
  return {{"seconds",
           {{"upload", device->upload},
            {"count", device->count},
            {"capture", device->capture},
            {"read_back", device->read_back},
            {"weld", device->weld}}},
          {"bytes_uploaded", device->bytes_uploaded},
          {"bytes_captured", device->bytes_captured}};
}

convert::Json json_of(const bench::BenchRow& row, const bench::BenchResult& result) {
  return {{"method", word_of(row.method)},
          {"backend", row.backend},
          {"size", result.levels[row.level].size},
          {"threads", row.threads},
          {"triangles", row.triangles},
          {"seconds", {{"median", row.median_seconds}, {"min", row.min_seconds}, {"max", row.max_seconds}}},
          {"device", json_of(row.device)},
          {"position", json_of_position(row)},
          {"smooth_normals", json_of(row.smooth_normals)},
          {"flat_normals", json_of(row.flat_normals)},
          {"area_error", json_or_null(row.area_error)},
          {"volume_error", json_or_null(row.volume_error)},
          {"on_front", row.on_front}};
}

std::string number_cell(const std::optional<double>& value) { return value ? fmt::format("{}", *value) : ""; }

// Returns the times of the GPU's steps; empty without a GPU.
std::string device_text(const bench::BenchResult& result) {
  std::vector<std::vector<std::string>> rows{{"method", "backend", "size", "threads", "draw", "cells/s", "count",
                                              "capture", "upload", "read back", "weld", "uploaded", "captured"},
                                             {"", "", "", "", "ms", "", "ms", "ms", "ms", "ms", "ms", "", ""}};
  for (const bench::BenchRow& row : result.rows) {
    if (!row.device) continue;
    const bench::BenchDeviceTimes& times = *row.device;
    const bench::BenchLevel& level = result.levels[row.level];
    rows.push_back({std::string(word_of(row.method)), row.backend, level.size, fmt::format("{}", row.threads),
                    milliseconds(times.draw()), fmt::format("{:.2e}", static_cast<double>(level.cells) / times.draw()),
                    milliseconds(times.count), milliseconds(times.capture), milliseconds(times.upload),
                    milliseconds(times.read_back), milliseconds(times.weld), format_byte_size(times.bytes_uploaded),
                    format_byte_size(times.bytes_captured)});
  }
  if (rows.size() == 2) return "";
  return "Times on the GPU, medians: draw = count + capture; cells/s counts all cells of the grid\n" +
         aligned_table(rows, 2) + "\n";
}

}  // namespace

std::string aligned_table(const std::vector<std::vector<std::string>>& rows, std::size_t left) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      line += c < left ? fmt::format("  {:<{}}", row[c], widths[c]) : fmt::format("  {:>{}}", row[c], widths[c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string bench_table(const bench::BenchResult& result, int repeats) {
  std::string text = fmt::format("{} at iso {}\n", printable(result.input), result.iso);
  text += fmt::format("Truth: {}.\n", result.truth);
  text += fmt::format("Times: extraction alone, median of {} (least .. most), {}.\n\n", repeats, cpu_name());
  std::vector<std::vector<std::string>> rows{
      {"method", "backend", "size", "threads", "triangles", "ms", "", "rms", "max", "rms", "max", "smooth", "flat",
       "area", "volume", ""},
      {"", "", "", "", "", "", "", "voxels", "voxels", "world", "world", "deg", "deg", "%", "%", ""}};
  for (const bench::BenchRow& row : result.rows) {
    const auto length = [&](const auto& of) { return row.position ? fmt::format("{:.3g}", of(*row.position)) : "-"; };
    rows.push_back({std::string(word_of(row.method)), row.backend, result.levels[row.level].size,
                    fmt::format("{}", row.threads), fmt::format("{}", row.triangles), milliseconds(row.median_seconds),
                    fmt::format("({} .. {})", milliseconds(row.min_seconds), milliseconds(row.max_seconds)),
                    length([](const auto& position) { return position.rms.voxels; }),
                    length([](const auto& position) { return position.max.voxels; }),
                    length([](const auto& position) { return position.rms.world; }),
                    length([](const auto& position) { return position.max.world; }), angle_text(row.smooth_normals),
                    angle_text(row.flat_normals), percent_text(row.area_error), percent_text(row.volume_error),
                    row.on_front ? "*" : ""});
  }
  text += aligned_table(rows, 2);
  for (const std::string& note : result.notes) text += fmt::format("Note: {}.\n", printable(note));
  if (const std::uint64_t points = unmeasured_points(result); points > 0) {
    text +=
        fmt::format("Not included: up to {} of a mesh without a surface to measure to.\n", counted(points, "point"));
  }
  text += "\n";
  if (std::ranges::count(result.levels, false, &bench::BenchLevel::is_truth) >= 2) text += orders_text(result) + "\n";
  return text + device_text(result) + front_text(result);
}

std::string bench_csv(const std::vector<bench::BenchResult>& results) {
  std::string text =
      "input,iso,method,backend,size,spacing,threads,triangles,median_seconds,min_seconds,max_seconds,rms_voxels,"
      "max_voxels,rms_world,max_world,unmeasured_points,smooth_normals_degrees,flat_normals_degrees,area_error,"
      "volume_error,on_front\n";
  for (const bench::BenchResult& result : results) {
    for (const bench::BenchRow& row : result.rows) {
      const bench::BenchLevel& level = result.levels[row.level];
      const auto length = [&](const auto& of) {
        return number_cell(row.position ? std::optional<double>(of(*row.position)) : std::nullopt);
      };
      const auto degrees = [](const std::optional<accuracy::AngleStatistics>& angles) {
        return number_cell(angles ? std::optional(angles->rms_degrees) : std::nullopt);
      };
      text += fmt::format(
          "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_cell(result.input), result.iso,
          word_of(row.method), row.backend, level.size, level.spacing, row.threads, row.triangles, row.median_seconds,
          row.min_seconds, row.max_seconds, length([](const auto& position) { return position.rms.voxels; }),
          length([](const auto& position) { return position.max.voxels; }),
          length([](const auto& position) { return position.rms.world; }),
          length([](const auto& position) { return position.max.world; }),
          row.position ? fmt::format("{}", row.position->unmeasured()) : "", degrees(row.smooth_normals),
          degrees(row.flat_normals), number_cell(row.area_error), number_cell(row.volume_error), row.on_front ? 1 : 0);
    }
  }
  return text;
}

convert::Json bench_json(const std::vector<bench::BenchResult>& results, int repeats) {
  convert::Json benchmarks = convert::Json::array();
  for (const bench::BenchResult& result : results) {
    convert::Json levels = convert::Json::array();
    for (const bench::BenchLevel& level : result.levels)
      levels.push_back(
          {{"size", level.size}, {"cells", level.cells}, {"spacing", level.spacing}, {"is_truth", level.is_truth}});
    convert::Json rows = convert::Json::array();
    for (const bench::BenchRow& row : result.rows) rows.push_back(json_of(row, result));
    convert::Json orders = convert::Json::array();
    for (const bench::BenchOrders& order : result.orders) {
      orders.push_back({{"method", word_of(order.method)},
                        {"backend", order.backend},
                        {"position", json_of(order.position)},
                        {"smooth_normals", json_of(order.smooth_normals)},
                        {"flat_normals", json_of(order.flat_normals)},
                        {"area", json_of(order.area)},
                        {"volume", json_of(order.volume)}});
    }
    benchmarks.push_back({{"input", result.input},
                          {"iso", result.iso},
                          {"truth", result.truth},
                          {"notes", result.notes},
                          {"levels", std::move(levels)},
                          {"rows", std::move(rows)},
                          {"orders", std::move(orders)}});
  }
  return {{"schema", word_of(convert::JsonDocument::bench)},
          {"generator", generator()},
          {"device", cpu_name()},
          {"repeats", repeats},
          {"benchmarks", std::move(benchmarks)}};
}

}  // namespace isoextract::cli
