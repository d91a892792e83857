// Tells whether stderr is a terminal and shows colors.
#pragma once

namespace isoextract::cli {

// Returns true if stderr is a terminal that understands escape sequences (TERM is set and not "dumb").
[[nodiscard]] bool stderr_is_terminal();

// Returns true if messages may have colors: stderr is a terminal, and the variable NO_COLOR is unset or empty
// (no-color.org).
[[nodiscard]] bool stderr_has_colors();

}  // namespace isoextract::cli
