// gnuplot as a process of its own: a script in, a picture out. No shell, no files besides.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract::cli {

// Fails with ErrorCode::unavailable where there is no gnuplot to run for `option`; the hint names its package.
[[nodiscard]] Result<void> check_gnuplot(std::string_view option);

// What `script` writes to its standard output, without the user's settings. Fails with ErrorCode::unavailable, and
// gnuplot's own words, if it does not end well or writes nothing.
[[nodiscard]] Result<std::string> run_gnuplot(const std::string& script);

// `text` as a string of a script, whatever is in it.
[[nodiscard]] std::string gnuplot_quoted(std::string_view text);

enum class PictureFormat { svg, png };

// The first lines of a script.
[[nodiscard]] std::string plot_terminal(PictureFormat format);

// Of the n-th line: told apart with any colour vision; they repeat.
[[nodiscard]] std::string_view plot_colour(std::size_t n);

}  // namespace isoextract::cli
