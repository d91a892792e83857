// Makes the plot of `isoextract bench`, error over run time, as a gnuplot script.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmark.hpp"
#include "cli/gnuplot.hpp"

namespace isoextract::cli {

// Returns a script with logarithmic axes and one line per input, method, backend and number of threads, from the rows
// with a measured error. Labels give the sizes, once for lines that differ only in threads. Rings mark the points on
// the Pareto front of each input (bench::BenchRow::on_front). Requires a row with a measured error.
[[nodiscard]] std::string error_plot_script(const std::vector<bench::BenchResult>& results, int repeats,
                                            PictureFormat format);

}  // namespace isoextract::cli
