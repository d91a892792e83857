// What `isoextract bench` found, as a table, as CSV and as JSON.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmark.hpp"
#include "convert/json_type.hpp"

namespace isoextract::cli {

// Columns as wide as their widest cell, right-aligned but for the first `left` of them.
[[nodiscard]] std::string aligned_table(const std::vector<std::vector<std::string>>& rows, std::size_t left);

// For a terminal: the rows, the notes, the orders of convergence (of two sizes or more), the front.
[[nodiscard]] std::string bench_table(const bench::BenchResult& result, int repeats);

// One line a row under a line of names; cells that are not known are empty. RFC 4180 with "\n".
[[nodiscard]] std::string bench_csv(const std::vector<bench::BenchResult>& results);

// {"generator", "device", "repeats", "benchmarks": [{"input", "iso", "truth", "notes", "levels", "rows", "orders"}]}
[[nodiscard]] convert::Json bench_json(const std::vector<bench::BenchResult>& results, int repeats);

}  // namespace isoextract::cli
