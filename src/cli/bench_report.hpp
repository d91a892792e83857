// Formats the results of `isoextract bench` as a table, as CSV and as JSON.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmark.hpp"
#include "convert/json_type.hpp"

namespace isoextract::cli {

// Formats rows as aligned columns, one line each: the first `left` columns left-aligned, the others right-aligned.
[[nodiscard]] std::string aligned_table(const std::vector<std::vector<std::string>>& rows, std::size_t left);

// Returns text for a terminal: the rows, the notes, the orders of convergence, the times of the GPU's steps, the Pareto
// front. Orders need at least two sizes besides the one that is the truth (bench::BenchLevel::is_truth).
[[nodiscard]] std::string bench_table(const bench::BenchResult& result, int repeats);

// Returns a header line and one line per row, without the times of the GPU's steps; unknown cells are empty. RFC 4180
// with "\n" as line end.
[[nodiscard]] std::string bench_csv(const std::vector<bench::BenchResult>& results);

// Returns {"schema", "generator", "device", "repeats", "benchmarks": [{"input", "iso", "truth", "notes", "levels",
// "rows", "orders"}]}; "device" is the name of the CPU. Times are in seconds.
[[nodiscard]] convert::Json bench_json(const std::vector<bench::BenchResult>& results, int repeats);

}  // namespace isoextract::cli
