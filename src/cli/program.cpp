#include "cli/program.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/help_topics.hpp"
#include "cli/messages.hpp"
#include "cli/options/run.hpp"
#include "cli/plan.hpp"
#include "cli/rank_run.hpp"
#include "cli/remedies.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

// Opens closed standard streams. Otherwise the next file opened would get such a descriptor, and messages could be
// written into the mesh. Opens stdout for reading, so that writing to it still fails.
void keep_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    [[maybe_unused]] const int opened = ::open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
}

Result<int> run_arguments(const std::vector<std::string>& arguments) {
  const auto program = make_program();
  if (arguments.empty()) {
    if (!is_later_rank()) fmt::print(stderr, "{}", short_usage(*program));
    return exit_code_of(ErrorCode::usage);
  }
  std::vector<std::string> names;
  for (const Option* option : find_subcommand(*program, arguments).options().options()) {
    if (!option->is_positional()) names.push_back(option->name());
  }
  set_options_of_hints(std::move(names));
  const auto parsed = parse_command_line(*program, arguments);
  if (!parsed) {
    if (!is_later_rank()) find_command(*program, arguments).report_failure(arguments, parsed.error());
    return tl::unexpected(parsed.error());
  }
  const bool is_shared = parsed->command->shares_work() && !parsed->help;
  if (is_shared) share_machine();
  if (is_later_rank() && !is_shared) return kDone;
  if (parsed->help) {
    TRY(print_to_stdout(help_of_command(*parsed->command, *parsed->help)));
    return kDone;
  }
  if (ranks_of_run() != nullptr && !is_shared) {
    const RunFlags* const run = parsed->command->run_flags();
    const auto shown = run != nullptr ? plan_messages(*run) : MessageChoice();  // the command reports a failure
    Messages(shown.value_or(MessageChoice()))
        .note({NoteId::shard, fmt::format("{}: rank 0 does all work of this command", ranks_text())});
  }
  return parsed->command->run(arguments);
}

// Removes unfinished files and says so, then ends the process by the signal's default action. Calls only functions that
// are safe in a signal handler.
extern "C" void on_end(int signal) {
  files::OutputFile::remove_unfinished();
  tell_ended_by_signal();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

// Handles the signals by which terminals, batch queues (SIGXCPU, SIGUSR1, SIGUSR2) and timers (SIGALRM) end a process.
// Signals that the shell set to be ignored (nohup) stay ignored.
void leave_nothing_when_interrupted() {
  for (const int signal : {SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU, SIGALRM, SIGUSR1, SIGUSR2}) {
    if (std::signal(signal, on_end) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

}  // namespace

int run(int argc, char** argv) {
  keep_standard_streams();
  // Ignored, so that a closed pipe or a file-size limit becomes a write error with a message and an exit code.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  leave_nothing_when_interrupted();
  const std::vector<std::string> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
  return run_on_ranks(arguments, [&] { return run_arguments(arguments); });
}

}  // namespace isoextract::cli
