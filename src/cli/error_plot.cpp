#include "cli/error_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"
#include "cli/gnuplot.hpp"

namespace isoextract::cli {
namespace {

constexpr std::array<int, 4> kPoints{7, 5, 9, 13};  // filled circle, square, triangle, diamond

// One line of the plot: the results of one input, method, backend and number of threads.
struct Line {
  std::string hue;  // lines of the same hue differ only in their threads
  int threads = 1;
  std::string title;
  std::string data;
};

template <class T>
std::size_t place_of(std::vector<T>& known, const T& value) {
  const auto found = std::ranges::find(known, value);
  const auto place = static_cast<std::size_t>(found - known.begin());
  if (found == known.end()) known.push_back(value);
  return place;
}

std::string data_row(const bench::BenchResult& result, const bench::BenchRow& row) {
  return fmt::format("{:.9g} {:.9g} {}\n", 1e3 * row.median_seconds, row.rms_above_rounding(),
                     result.levels[row.level].size);
}

std::vector<Line> lines_of(const std::vector<bench::BenchResult>& results) {
  std::vector<Line> lines;
  for (const bench::BenchResult& result : results) {
    for (const bench::BenchRow& row : result.rows) {
      if (!row.position) continue;
      std::string hue(extract::method_info(row.method).title);
      if (row.backend != "cpu") hue += " on " + row.backend;
      if (results.size() > 1) hue = fmt::format("{}: {}", result.input, hue);
      auto line = std::ranges::find_if(
          lines, [&](const Line& known) { return known.hue == hue && known.threads == row.threads; });
      if (line == lines.end()) {
        const std::string title = fmt::format("{}, {}", hue, counted(row.threads, "thread"));
        line = lines.insert(line, {hue, row.threads, title, ""});
      }
      line->data += data_row(result, row);
    }
  }
  return lines;
}

std::string front_of(const std::vector<bench::BenchResult>& results) {
  std::string data;
  for (const bench::BenchResult& result : results) {
    for (const bench::BenchRow& row : result.rows) {
      if (row.on_front) data += data_row(result, row);
    }
  }
  return data;
}

// Returns the range, extended to contain at least two powers of ten, which are the only labels of a logarithmic axis.
std::string range_with_numbers(double low, double high) {
  if (std::floor(std::log10(high)) - std::ceil(std::log10(low)) < 1) {
    low = std::pow(10, std::floor(std::log10(low)));
    high = std::pow(10, std::ceil(std::log10(high)));
  }
  return fmt::format("[{:.6g}:{:.6g}]", low, high);
}

// Returns the axis ranges with a margin around the points.
std::string ranges(const std::vector<bench::BenchResult>& results) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double least[2] = {kInfinity, kInfinity};
  double most[2] = {0, 0};
  for (const bench::BenchResult& result : results) {
    for (const bench::BenchRow& row : result.rows) {
      if (!row.position) continue;
      const double place[2] = {1e3 * row.median_seconds, row.rms_above_rounding()};
      for (int axis = 0; axis < 2; ++axis) {
        if (!(place[axis] > 0)) continue;
        least[axis] = std::min(least[axis], place[axis]);
        most[axis] = std::max(most[axis], place[axis]);
      }
    }
  }
  return fmt::format("set xrange {}\nset yrange {}\n", range_with_numbers(least[0] / 2, most[0] * 2.5),
                     range_with_numbers(least[1] / 2, most[1] * 3));
}

}  // namespace

std::string error_plot_script(const std::vector<bench::BenchResult>& results, int repeats, PictureFormat format) {
  std::string script = plot_terminal(format);
  std::vector<std::string> inputs;
  for (const bench::BenchResult& result : results)
    inputs.push_back(fmt::format("{} at iso {}", result.input, result.iso));
  script += fmt::format("set title {} noenhanced\n",
                        gnuplot_quoted(fmt::format("Error against run time: {}", fmt::join(inputs, ", "))));
  script += fmt::format("set xlabel 'extraction, ms (median of {})'\n", repeats);
  script +=
      "set ylabel 'distance from the true surface, rms, world units'\n"
      "set logscale xy\n"
      "set format x '%g'\n"
      "set format y '10^{%T}'\n"
      "set grid xtics ytics mxtics mytics linecolor '#d8d8d8' linewidth 1, linecolor '#efefef' linewidth 0.5\n"
      "set key top right noenhanced samplen 2.5 spacing 1.2\n";
  script += kPlotAxes;
  script += ranges(results);
  const std::vector<Line> lines = lines_of(results);
  std::vector<std::string> hues;
  std::vector<int> threads;
  std::vector<std::string> plots;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const Line& line = lines[l];
    script += fmt::format("$line{} << END\n{}END\n", l, line.data);
    const std::string_view color = plot_color(place_of(hues, line.hue));
    const std::size_t shape = place_of(threads, line.threads);
    plots.push_back(
        fmt::format("$line{} using 1:2 with linespoints linecolor '{}' linewidth 2 dashtype {} pointtype {} "
                    "pointsize 0.8 title {}",
                    l, color, shape % 4 + 1, kPoints[shape % kPoints.size()], gnuplot_quoted(line.title)));
    // Lines of one hue have the same grid sizes at the same errors, so only one line of each hue gets labels. Labels of
    // the first hue are on the left and below, those of the second on the right and above, then in turn.
    const std::size_t hue = place_of(hues, line.hue);
    const bool left = hue % 2 == 0;
    const bool first = l == 0 || lines[l - 1].hue != line.hue;
    const bool last = l + 1 == lines.size() || lines[l + 1].hue != line.hue;
    if (left ? !last : !first) continue;
    plots.push_back(fmt::format("$line{} using 1:2:3 with labels noenhanced {} textcolor '{}' font ',12' notitle", l,
                                left ? "right offset -1.1,-0.8" : "left offset 1.1,0.8", color));
  }
  script += fmt::format("$front << END\n{}END\n", front_of(results));
  plots.emplace_back(
      "$front using 1:2 with points pointtype 6 pointsize 1.9 linewidth 1.5 linecolor '#000000' "
      "title 'best error for its time'");
  return script + fmt::format("plot {}\n", fmt::join(plots, ", \\\n     "));
}

}  // namespace isoextract::cli
