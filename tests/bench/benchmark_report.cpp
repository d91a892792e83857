#include "bench/benchmark_report.hpp"

#include <algorithm>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include "base/machine.hpp"
#include "base/median.hpp"
#include "base/version.hpp"
#include "bench/vtk_threads.hpp"

namespace isoextract::bench {
namespace {

std::uint64_t bytes_of(const Row& row) { return row.outcome.bytes_read + row.outcome.bytes_written; }

double samples_per_second(const Group& group, const Row& row) {
  return 1000 * static_cast<double>(group.samples) / median(row.milliseconds);
}

double gigabytes_per_second(const Row& row) {
  return 1e-6 * static_cast<double>(bytes_of(row)) / median(row.milliseconds);
}

// Three digits, so that microseconds and seconds can stand in one column.
std::string milliseconds(double value) {
  return value < 100 ? fmt::format("{:.3g}", value) : fmt::format("{:.0f}", value);
}

std::string title(const Group& group) {
  const std::string size = group.size > 0 ? fmt::format("{}^3", group.size)
                                          : fmt::format("{} x {} x {}", group.dims.x, group.dims.y, group.dims.z);
  return fmt::format("{} {}, {}, {}", group.input, size, group.type,
                     group.smooth_normals ? "smooth normals" : "no normals");
}

bool is_extraction(const Row& row) { return row.outcome.triangles > 0; }

struct Smaller {
  int size;
  const Row* row;
};

// The same contestant with as many threads, in the next smaller size of the same input.
std::optional<Smaller> find_smaller(const std::vector<Group>& groups, const Group& group, const Row& row) {
  std::optional<Smaller> found;
  for (const Group& other : groups) {
    if (other.input != group.input || other.type != group.type || other.smooth_normals != group.smooth_normals)
      continue;
    if (other.size >= group.size || (found && other.size < found->size)) continue;
    const auto same = std::ranges::find_if(other.rows, [&](const Row& candidate) {
      return candidate.program == row.program && candidate.name == row.name && candidate.threads == row.threads;
    });
    if (same != other.rows.end()) found = {other.size, &*same};
  }
  return found;
}

nlohmann::json json_of(const Group& group, const Row& row) {
  nlohmann::json json{{"input", group.input},
                      {"dims", {group.dims.x, group.dims.y, group.dims.z}},
                      {"samples", group.samples},
                      {"type", group.type},
                      {"normals", group.smooth_normals ? "smooth" : "none"},
                      {"name", row.name},
                      {"program", row.program},
                      {"threads", row.threads},
                      {"first_ms", row.first_milliseconds},
                      {"median_ms", median(row.milliseconds)},
                      {"min_ms", std::ranges::min(row.milliseconds)},
                      {"max_ms", std::ranges::max(row.milliseconds)},
                      {"rounds_ms", row.milliseconds},
                      {"isoextract_to_this", row.isoextract_to_this},
                      {"bytes_read", row.outcome.bytes_read},
                      {"bytes_written", row.outcome.bytes_written},
                      {"gigabytes_per_second", gigabytes_per_second(row)}};
  if (group.size > 0) json["size"] = group.size;
  if (is_extraction(row)) {
    json["triangles"] = row.outcome.triangles;
    json["vertices"] = row.outcome.vertices;
    json["samples_per_second"] = samples_per_second(group, row);
  }
  return json;
}

}  // namespace

std::string machine_line() {
  return fmt::format("{}, {} threads; VTK's SMP backend is {}\n", cpu_name(), std::thread::hardware_concurrency(),
                     vtk_backend());
}

std::string group_table(const Group& group) {
  const std::size_t rounds = group.rows.front().milliseconds.size();
  std::string text = fmt::format("\n{}; median of {} alternating rounds\n\n", title(group), rounds);
  text += "| what | threads | first, ms | ms | min | max | isoextract to this | triangles | vertices | Msamples/s |";
  text += " GB/s |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
  for (const Row& row : group.rows) {
    const std::string counts = is_extraction(row)
                                   ? fmt::format("{} | {} | {:.0f}", row.outcome.triangles, row.outcome.vertices,
                                                 1e-6 * samples_per_second(group, row))
                                   : "| |";
    text +=
        fmt::format("| {}: {} | {} | {} | {} | {} | {} | {:.2f} | {} | {:.1f} |\n", row.program, row.name, row.threads,
                    milliseconds(row.first_milliseconds), milliseconds(median(row.milliseconds)),
                    milliseconds(std::ranges::min(row.milliseconds)), milliseconds(std::ranges::max(row.milliseconds)),
                    row.isoextract_to_this, counts, gigabytes_per_second(row));
  }
  return text;
}

std::string growth_table(const std::vector<Group>& groups) {
  std::string lines;
  for (const Group& group : groups) {
    for (const Row& row : group.rows) {
      if (row.program != generator()) continue;
      const std::optional<Smaller> before = find_smaller(groups, group, row);
      if (!before) continue;
      lines +=
          fmt::format("| {} | {} | {} | {}^3 | {:.2f} | {:.2f} |\n", title(group), row.name, row.threads, before->size,
                      static_cast<double>(bytes_of(row)) / static_cast<double>(bytes_of(*before->row)),
                      median(row.milliseconds) / median(before->row->milliseconds));
    }
  }
  if (lines.empty()) return {};
  return "\nGrowth of bytes (read and written) and of time from the size before\n\n"
         "| input | method | threads | from | bytes, times | time, times |\n|---|---|---:|---:|---:|---:|\n" +
         lines;
}

nlohmann::json report_json(const std::vector<Group>& groups, int rounds) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Group& group : groups) {
    for (const Row& row : group.rows) rows.push_back(json_of(group, row));
  }
  return {{"processor", cpu_name()},
          {"hardware_threads", std::thread::hardware_concurrency()},
          {"vtk_smp_backend", vtk_backend()},
          {"rounds", rounds},
          {"rows", std::move(rows)}};
}

}  // namespace isoextract::bench
