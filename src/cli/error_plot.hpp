// Makes the plot of `isoextract bench`, error over run time, as a gnuplot script.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmark.hpp"
#include "cli/gnuplot.hpp"

namespace isoextract::cli {

// Returns a script with logarithmic axes and one line per input, method, backend and number of threads. Points are
// labeled with their size; rings mark points that no other point beats in both error and time.
[[nodiscard]] std::string error_plot_script(const std::vector<bench::BenchResult>& results, int repeats,
                                            PictureFormat format);

}  // namespace isoextract::cli
