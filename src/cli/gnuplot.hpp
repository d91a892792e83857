// Runs gnuplot as a child process that turns a script into a picture, without a shell and without files.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract::cli {

// Checks that gnuplot runs. Otherwise fails with ErrorCode::unavailable: the message says that `option` needs gnuplot,
// the hint says how to install it.
[[nodiscard]] Result<void> check_gnuplot(std::string_view option);

// Runs the script without the user's settings and returns gnuplot's standard output. Fails with ErrorCode::unavailable
// and the first line of gnuplot's message if gnuplot does not start, fails or writes nothing.
[[nodiscard]] Result<std::string> run_gnuplot(const std::string& script);

// Quotes any text as a string of a script; control characters become '?'.
[[nodiscard]] std::string gnuplot_quoted(std::string_view text);

enum class PictureFormat { svg, png };

// Returns the first line of a script: it sets format, size, font and background.
[[nodiscard]] std::string plot_terminal(PictureFormat format);

// Lines of a script: the plot has a left and a lower axis, and no tics on the other sides.
inline constexpr std::string_view kPlotAxes = R"(set border 3 linecolor '#606060'
set tics nomirror textcolor '#303030'
)";

// Returns the color of line n. The palette suits all kinds of color vision, and repeats after 6 colors.
[[nodiscard]] std::string_view plot_color(std::size_t n);

}  // namespace isoextract::cli
