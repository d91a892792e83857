#include "cli/frame_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/gnuplot.hpp"

namespace isoextract::cli {
namespace {

constexpr std::size_t kFigures = 4;
constexpr std::size_t kMostTitles = 20;   // titles of surfaces in the key
constexpr std::size_t kTitlesInARow = 4;  // including the titles of failed frames
constexpr double kHeightOfKeyRow = 0.035;
// The plots fill the picture between these fractions of its height.
constexpr double kLowest = 0.09;
constexpr double kHighest = 0.97;
constexpr double kGap = 0.045;
constexpr double kMostTics = 4;

struct Figure {
  std::string_view name;
  std::string_view text_if_empty;  // text if no surface has this figure
  bool is_count;
};
constexpr std::array<Figure, kFigures> kFigureNames{
    Figure{"triangles", "no frame has a surface", true}, Figure{"area", "no frame has a surface of known area", false},
    Figure{"volume", "no surface is closed: none has a volume", false},
    Figure{"components", "no frame has a surface of known components", true}};

// A status of frames without a surface, and the color of such frames.
struct Ended {
  batch::FrameStatus status;
  std::string_view color;
};
constexpr std::array<Ended, 3> kEnded{Ended{batch::FrameStatus::failed, "#a61b1b"},
                                      Ended{batch::FrameStatus::cancelled, "#b08030"},
                                      Ended{batch::FrameStatus::not_started, "#808080"}};

template <class T>
std::optional<double> number(const std::optional<T>& value) {
  return value ? std::optional(static_cast<double>(*value)) : std::nullopt;
}

std::array<std::optional<double>, kFigures> figures_of(const batch::SurfaceFigures& surface) {
  return {static_cast<double>(surface.triangles), number(surface.area), number(surface.volume),
          number(surface.components)};
}

std::string text_of(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? fmt::format("{:.9g}", *value) : std::string("NaN");
}

// Returns the largest number of surfaces in a frame.
std::size_t most_surfaces(std::span<const batch::FrameRow> rows) {
  std::size_t most = 0;
  for (const batch::FrameRow& row : rows) most = std::max(most, row.figures.surfaces.size());
  return most;
}

// Returns the grid and iso value of the n-th surface if all frames agree, otherwise its number.
std::string title_of(std::span<const batch::FrameRow> rows, std::size_t n) {
  std::optional<std::string> title;
  for (const batch::FrameRow& row : rows) {
    if (n >= row.figures.surfaces.size()) continue;
    const batch::SurfaceFigures& surface = row.figures.surfaces[n];
    std::string found = fmt::format("{}{}{}", surface.grid, surface.grid.empty() ? "" : " ", surface.id.name());
    if (title && *title != found) return fmt::format("surface {}", n + 1);
    title = std::move(found);
  }
  return title.value_or("");
}

// Returns a tic distance of 1, 2 or 5 times a power of ten that gives at most kMostTics tics in `length`.
double step_for(double length) {
  const double power = std::pow(10, std::floor(std::log10(length / kMostTics)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power * kMostTics >= length) return factor * power;
  }
  return 10 * power;
}

// Returns "250,000" or "1.2e+08".
std::string tic_text(double value) {
  if (std::abs(value) >= 1e6 || value != std::round(value)) return fmt::format("{:.4g}", value);
  std::string digits = fmt::format("{:.0f}", value);
  const std::size_t first = digits.starts_with('-') ? 1 : 0;
  for (std::size_t at = digits.size(); at > first + 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

struct Range {
  double low = 0;
  double high = 0;
};

// Returns the range of a figure over all surfaces, including 0; nullopt if all values are 0 or missing.
std::optional<Range> range_of(std::span<const batch::FrameRow> rows, std::size_t figure) {
  std::optional<Range> range;
  for (const batch::FrameRow& row : rows) {
    for (const batch::SurfaceFigures& surface : row.figures.surfaces) {
      const auto value = figures_of(surface)[figure];
      if (!value || !std::isfinite(*value)) continue;
      if (!range) range = Range();
      range->low = std::min(range->low, *value);
      range->high = std::max(range->high, *value);
    }
  }
  if (range && range->low == range->high) return std::nullopt;  // surfaces without triangles
  return range;
}

struct Axis {
  Range range;
  std::string script;
};

// Returns the range and tics of a value axis.
Axis value_axis(const Range& range, bool is_count) {
  const double step = std::max(step_for(range.high - range.low), is_count ? 1.0 : 0.0);
  const auto first = static_cast<std::int64_t>(std::floor(range.low / step));
  const auto last = static_cast<std::int64_t>(std::ceil(range.high / step));
  std::vector<std::string> tics;
  for (std::int64_t i = first; i <= last; ++i) {
    const double value = static_cast<double>(i) * step;
    tics.push_back(fmt::format("'{}' {:.9g}", tic_text(value), value));
  }
  const Range whole{static_cast<double>(first) * step, static_cast<double>(last) * step};
  return {whole,
          fmt::format("set yrange [{:.9g}:{:.9g}]\nset ytics ({})\n", whole.low, whole.high, fmt::join(tics, ", "))};
}

// Returns the frame axis: covers all frames, also those without a surface, with tics at whole numbers.
std::string frame_axis(std::span<const batch::FrameRow> rows) {
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for (const batch::FrameRow& row : rows) {
    first = std::min(first, static_cast<double>(row.frame));
    last = std::max(last, static_cast<double>(row.frame));
  }
  if (rows.empty()) first = last = 0;
  const double room = std::max(0.5, (last - first) / 50);
  return fmt::format("set xrange [{:.12g}:{:.12g}]\nset xtics {:.12g}\n", first - room, last + room,
                     std::max(1.0, step_for(std::max(1.0, (last - first) / 2))));
}

// Returns the data of the plots: the figures of each surface, and the frame numbers for each status in kEnded.
std::string data_blocks(std::span<const batch::FrameRow> rows, std::size_t surfaces) {
  std::string script;
  for (std::size_t n = 0; n < surfaces; ++n) {
    script += fmt::format("$surface{} << END\n", n);
    for (const batch::FrameRow& row : rows) {
      script += fmt::format("{}", row.frame);
      for (std::size_t figure = 0; figure < kFigures; ++figure) {
        const auto& found = row.figures.surfaces;
        script += " " + text_of(n < found.size() ? figures_of(found[n])[figure] : std::nullopt);
      }
      script += "\n";
    }
    script += "END\n";
  }
  for (std::size_t e = 0; e < kEnded.size(); ++e) {
    script += fmt::format("$ended{} << END\n", e);
    for (const batch::FrameRow& row : rows) {
      if (row.status == kEnded[e].status) script += fmt::format("{}\n", row.frame);
    }
    script += "END\n";
  }
  return script;
}

}  // namespace

std::string frame_plot_script(std::span<const batch::FrameRow> rows, PictureFormat format) {
  const std::size_t surfaces = most_surfaces(rows);
  const std::size_t titles = std::min(surfaces, kMostTitles) + kEnded.size();
  const double key_rows = std::ceil(static_cast<double>(titles) / static_cast<double>(kTitlesInARow));
  std::string script = plot_terminal(format) + data_blocks(rows, surfaces);
  script += kPlotAxes;
  script += fmt::format(
      "set multiplot layout {},1 margins screen 0.12,0.98,{},{} spacing screen {}\n"
      "set grid linecolor '#d8d8d8'\n"
      "set key at screen 0.55,0.99 center top horizontal noenhanced maxcols {}\n"
      "set label 1 '' at graph 0.5,0.5 center noenhanced textcolor '#606060'\n"
      "set format x ''\n",
      kFigures, kLowest, kHighest - key_rows * kHeightOfKeyRow, kGap, kTitlesInARow);
  script += frame_axis(rows);
  for (std::size_t figure = 0; figure < kFigures; ++figure) {
    const auto range = range_of(rows, figure);
    const Axis axis =
        range ? value_axis(*range, kFigureNames[figure].is_count) : Axis{{0, 1}, "set yrange [0:1]\nset ytics ()\n"};
    script += fmt::format("set ylabel '{}' offset screen -0.01,0\n", kFigureNames[figure].name);
    script += axis.script;
    if (figure + 1 == kFigures) script += "set format x '%.0f'\nset xlabel 'frame'\n";
    script += fmt::format("set label 1 {}\n", gnuplot_quoted(range ? "" : kFigureNames[figure].text_if_empty));
    std::vector<std::string> plots;
    for (std::size_t e = 0; e < kEnded.size(); ++e) {
      if (std::ranges::find(rows, kEnded[e].status, &batch::FrameRow::status) == rows.end()) continue;
      plots.push_back(
          fmt::format("$ended{} using 1:({:.9g}):(0):({:.9g}) with vectors nohead linewidth 1.5 dashtype "
                      "2 linecolor '{}' {}",
                      e, axis.range.low, axis.range.high - axis.range.low, kEnded[e].color,
                      figure == 0 ? fmt::format("title '{}'", word_of(kEnded[e].status)) : "notitle"));
    }
    for (std::size_t n = 0; range && n < surfaces; ++n) {
      const bool titled = figure == 0 && n < kMostTitles;
      plots.push_back(fmt::format(
          "$surface{} using 1:{} with linespoints pointtype 7 pointsize 0.4 linewidth 2 linecolor '{}' {}", n,
          figure + 2, plot_color(n), titled ? fmt::format("title {}", gnuplot_quoted(title_of(rows, n))) : "notitle"));
    }
    if (plots.empty()) plots.emplace_back("1/0 notitle");
    script += fmt::format("plot {}\n", fmt::join(plots, ", \\\n     "));
  }
  return script + "unset multiplot\n";
}

}  // namespace isoextract::cli
