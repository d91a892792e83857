#include "cli/frame_plot.hpp"

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/gnuplot.hpp"

namespace isoextract::cli {
namespace {

std::string text_of(const std::optional<double>& value) {
  return value ? fmt::format("{:.9g}", *value) : std::string("NaN");
}

template <class T>
std::optional<double> number(const std::optional<T>& value) {
  return value ? std::optional(static_cast<double>(*value)) : std::nullopt;
}

// How many surfaces the frames have at most.
std::size_t most_surfaces(std::span<const batch::FrameRow> rows) {
  std::size_t most = 0;
  for (const batch::FrameRow& row : rows) most = std::max(most, row.figures.surfaces.size());
  return most;
}

// The iso value of the n-th surfaces, if they have one.
std::string title_of(std::span<const batch::FrameRow> rows, std::size_t n) {
  std::optional<double> iso;
  for (const batch::FrameRow& row : rows) {
    if (n >= row.figures.surfaces.size()) continue;
    const double found = row.figures.surfaces[n].iso;
    if (iso && *iso != found) return fmt::format("surface {}", n + 1);
    iso = found;
  }
  return iso ? fmt::format("iso {}", *iso) : std::string();
}

}  // namespace

std::string frame_plot_script(std::span<const batch::FrameRow> rows, PictureFormat format) {
  constexpr std::array<std::string_view, 4> kFigures{"triangles", "area", "volume", "components"};
  std::string script = plot_terminal(format);
  const std::size_t surfaces = most_surfaces(rows);
  for (std::size_t n = 0; n < surfaces; ++n) {
    script += fmt::format("$surface{} << END\n", n);
    for (const batch::FrameRow& row : rows) {
      if (n >= row.figures.surfaces.size()) {
        script += fmt::format("{} NaN NaN NaN NaN\n", row.frame);
        continue;
      }
      const batch::SurfaceFigures& surface = row.figures.surfaces[n];
      script += fmt::format("{} {} {} {} {}\n", row.frame, surface.triangles, text_of(number(surface.area)),
                            text_of(number(surface.volume)), text_of(number(surface.components)));
    }
    script += "END\n";
  }
  script +=
      "set multiplot layout 4,1\n"
      "set grid linecolor '#d8d8d8'\n"
      "set border 3 linecolor '#606060'\n"
      "set tics nomirror textcolor '#303030'\n"
      "set key top right noenhanced\n"
      "set yrange [0:*]\n"
      "set lmargin 12\n";
  for (std::size_t figure = 0; figure < kFigures.size(); ++figure) {
    script += fmt::format("set ylabel '{}'\n", kFigures[figure]);
    if (figure + 1 == kFigures.size()) script += "set xlabel 'frame'\n";
    std::vector<std::string> plots;
    for (std::size_t n = 0; n < surfaces; ++n) {
      plots.push_back(
          fmt::format("$surface{} using 1:{} with linespoints pointtype 7 pointsize 0.4 linewidth 2 "
                      "linecolor '{}' title {}",
                      n, figure + 2, plot_colour(n), gnuplot_quoted(title_of(rows, n))));
    }
    if (plots.empty()) plots.emplace_back("NaN notitle");
    script += fmt::format("plot {}\n", fmt::join(plots, ", \\\n     "));
  }
  return script + "unset multiplot\n";
}

}  // namespace isoextract::cli
