#include "cli/lost_input.hpp"

#include <atomic>
#include <csignal>
#include <string>

#include <unistd.h>

#include "base/error.hpp"

namespace isoextract::cli {
namespace {

std::string message;  // made before the handler is there, which may not allocate

std::atomic_flag told;
static_assert(std::atomic<bool>::is_always_lock_free, "the handler may not lock");

extern "C" void end_with_message(int signal, siginfo_t* info, void* /*context*/) {
  if (info->si_code != BUS_ADRERR) {  // not a page that a file no longer has
    std::signal(signal, SIG_DFL);
    std::raise(signal);
    return;
  }
  // Other threads run into it as well; they wait for the end.
  while (told.test_and_set()) ::pause();
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, message.data(), message.size());
  ::_exit(static_cast<int>(ErrorKind::input));
}

}  // namespace

void report_lost_input() {
  // On a terminal the progress bar may stand in the line.
  message = ::isatty(STDERR_FILENO) == 1 ? "\r\x1b[K" : "";
  message +=
      "isoextract: error: the input became shorter, or could not be read further, while it was in use\n"
      "  hint: run again when nothing writes to the file, or on a copy of it\n";
  struct sigaction action {};
  action.sa_sigaction = end_with_message;
  action.sa_flags = SA_SIGINFO;
  ::sigaction(SIGBUS, &action, nullptr);
}

}  // namespace isoextract::cli
