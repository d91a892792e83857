#include "cli/terminal.hpp"

#include <cstdlib>
#include <string_view>

#include <unistd.h>

namespace isoextract::cli {

bool stderr_is_terminal() {
  const char* const terminal = std::getenv("TERM");
  return ::isatty(STDERR_FILENO) == 1 && terminal != nullptr && std::string_view(terminal) != "dumb";
}

bool stderr_has_colors() {
  const char* const refused = std::getenv("NO_COLOR");
  return stderr_is_terminal() && (refused == nullptr || *refused == '\0');
}

}  // namespace isoextract::cli
