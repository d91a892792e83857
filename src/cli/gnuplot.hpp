// Runs gnuplot as a child process that turns a script into a picture, without a shell and without files.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract::cli {

// Fails with ErrorCode::unavailable if gnuplot, which `option` needs, does not run; the hint names its package.
[[nodiscard]] Result<void> check_gnuplot(std::string_view option);

// Runs the script without the user's settings and returns its standard output. Fails with ErrorCode::unavailable and
// gnuplot's message if gnuplot fails or writes nothing.
[[nodiscard]] Result<std::string> run_gnuplot(const std::string& script);

// Quotes any text as a string of a script.
[[nodiscard]] std::string gnuplot_quoted(std::string_view text);

enum class PictureFormat { svg, png };

// Returns the first lines of a script.
[[nodiscard]] std::string plot_terminal(PictureFormat format);

// Returns the color of line n. The palette suits all kinds of color vision, and repeats.
[[nodiscard]] std::string_view plot_color(std::size_t n);

}  // namespace isoextract::cli
