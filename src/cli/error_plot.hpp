// The picture of `isoextract bench`: error over run time, as a gnuplot script.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmark.hpp"
#include "cli/gnuplot.hpp"

namespace isoextract::cli {

// Both axes logarithmic; one line for each input, method, backend and number of threads, points labelled with their
// size, and rings around those that nothing beats on both.
[[nodiscard]] std::string error_plot_script(const std::vector<bench::BenchResult>& results, int repeats,
                                            PictureFormat format);

}  // namespace isoextract::cli
