#include "cli/gpu_threads_report.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "base/version.hpp"
#include "cli/bench_report.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"

namespace isoextract::cli {
namespace {

const gpu::ThreadCreation& of(const gpu::ThreadCreationLevel& level, gpu::ThreadMaker maker) {
  return *std::ranges::find(level.makers, maker, &gpu::ThreadCreation::maker);
}

std::string ratio_text(double other, double tessellation) {
  return tessellation > 0 ? fmt::format("{:.2f}", other / tessellation) : "-";
}

}  // namespace

std::string gpu_threads_table(const gpu::ThreadCreationResult& result, int repeats) {
  std::string text = "One geometry-shader thread per cell, which ends immediately (Timokhin and Mikhaylyuk)\n";
  text += fmt::format("Times: a pass over all cells, median of {} (least .. most), {}.\n", repeats,
                      describe(result.device));
  text += fmt::format("Copying on the device: {:.1f} GB/s, counting reads and writes.\n\n",
                      result.copy_bytes_per_second / 1e9);
  std::vector<std::vector<std::string>> rows{
      {"cells", "threads by", "ms", "", "cells/s", "vertex data", "driver says", "time", "memory"}};
  for (const gpu::ThreadCreationLevel& level : result.levels) {
    const gpu::ThreadCreation& paper = of(level, gpu::ThreadMaker::tessellation);
    for (const gpu::ThreadCreation& row : level.makers) {
      const std::string size = fmt::format("{}^3", level.size);
      if (row.problem) {
        rows.push_back({size, std::string(gpu::thread_maker_name(row.maker)), *row.problem});
        continue;
      }
      const double cells = static_cast<double>(level.size) * level.size * level.size;
      rows.push_back({size, std::string(gpu::thread_maker_name(row.maker)),
                      fmt::format("{:.3g}", 1e3 * row.median_seconds),
                      fmt::format("({:.3g} .. {:.3g})", 1e3 * row.min_seconds, 1e3 * row.max_seconds),
                      fmt::format("{:.2e}", cells / row.median_seconds), format_byte_size(row.buffer_bytes),
                      row.driver_bytes ? format_byte_size(*row.driver_bytes) : "-",
                      ratio_text(row.median_seconds, paper.median_seconds),
                      ratio_text(static_cast<double>(row.buffer_bytes), static_cast<double>(paper.buffer_bytes))});
    }
  }
  text += aligned_table(rows, 2);
  text += "\nThe last columns give time and memory relative to tessellation. A dummy vertex has 4 bytes, a patch 16.\n";
  text += "The paper, GTX 1080 Ti, up to 2000^3: dummy vertices take 5 times the time and 8 times the memory.\n";
  return text;
}

convert::Json gpu_threads_json(const gpu::ThreadCreationResult& result, int repeats) {
  convert::Json levels = convert::Json::array();
  for (const gpu::ThreadCreationLevel& level : result.levels) {
    convert::Json makers = convert::Json::array();
    for (const gpu::ThreadCreation& row : level.makers) {
      convert::Json json{{"threads_by", gpu::thread_maker_name(row.maker)}};
      if (row.problem) {
        json["problem"] = *row.problem;
      } else {
        json["seconds"] = {{"median", row.median_seconds}, {"min", row.min_seconds}, {"max", row.max_seconds}};
        json["vertex_bytes"] = row.buffer_bytes;
        json["driver_bytes"] = row.driver_bytes ? convert::Json(*row.driver_bytes) : convert::Json(nullptr);
      }
      makers.push_back(std::move(json));
    }
    levels.push_back({{"size", level.size}, {"makers", std::move(makers)}});
  }
  return {{"schema", word_of(convert::JsonDocument::gpu_threads)},
          {"generator", generator()},
          {"device", describe(result.device)},
          {"repeats", repeats},
          {"copy_bytes_per_second", result.copy_bytes_per_second},
          {"gpu_threads", std::move(levels)}};
}

}  // namespace isoextract::cli
