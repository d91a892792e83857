#include "cli/commands.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "base/version.hpp"
#include "cli/batch_command.hpp"
#include "cli/batch_plan.hpp"
#include "cli/bench_command.hpp"
#include "cli/check_command.hpp"
#include "cli/command_line.hpp"
#include "cli/compare_command.hpp"
#include "cli/config_file.hpp"
#include "cli/convert_command.hpp"
#include "cli/devices_command.hpp"
#include "cli/generate_docs.hpp"
#include "cli/help_topics.hpp"
#include "cli/info_command.hpp"
#include "cli/jet_command.hpp"
#include "cli/jet_plan.hpp"
#include "cli/merge_command.hpp"
#include "cli/messages.hpp"
#include "cli/plan.hpp"
#include "cli/remedies.hpp"
#include "cli/render_command.hpp"
#include "cli/simulate_command.hpp"
#include "cli/simulate_plan.hpp"
#include "cli/stability_command.hpp"
#include "cli/threads.hpp"
#include "cli/verify_command.hpp"
#include "files/output_file.hpp"
#include "plugin_host/plugin_reader.hpp"

namespace isoextract::cli {
namespace {

constexpr int kDone = 0;

int report(const Error& error) {
  Messages(Verbosity::quiet).error(error);
  return exit_code_of(error.code);
}

int done_or_reported(const Result<void>& done) { return done ? kDone : report(done.error()); }

int print(std::string_view text) { return done_or_reported(print_to_stdout(text)); }

// Where a standard stream is closed, the next file opened would take its number, and messages would land in the mesh.
// stdout is opened for reading, so that writing to it still fails.
void keep_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    [[maybe_unused]] const int opened = ::open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
}

void choose_process(const InputFlags& input) {
  if (input.in_process) plugin_host::read_in_process();
}

int run_info_command(const InfoFlags& flags, const CLI::App& command) {
  choose_process(flags.input);
  const auto verbosity = plan_verbosity(flags.run);
  if (!verbosity) return report(verbosity.error());
  const auto plan = plan_info(flags, command);
  if (!plan) return report(plan.error());
  if (auto limited = limit_threads(flags.run.threads); !limited) return report(limited.error());
  const auto failure = run_info(*plan, Messages(*verbosity));
  return failure ? exit_code_of(failure->code) : kDone;
}

template <class Flags>
const RunFlags& run_flags(const Flags& flags) {
  if constexpr (requires { flags.conversion; }) {
    return flags.conversion.run;
  } else {
    return flags.run;
  }
}

// Of a command whose options become a plan: all of it is checked before any work.
template <class Flags, class Plan, class Run>
int plan_and_run(const Flags& flags, const Plan& plan_of, const Run& run) {
  if constexpr (requires { flags.conversion; }) {
    choose_process(flags.conversion.input);
  } else if constexpr (requires { flags.input; }) {
    choose_process(flags.input);
  }
  const RunFlags& asked = run_flags(flags);
  const auto verbosity = plan_verbosity(asked);
  if (!verbosity) return report(verbosity.error());
  const auto plan = plan_of(flags);
  if (!plan) return report(plan.error());
  if (auto limited = limit_threads(asked.threads); !limited) return report(limited.error());
  return done_or_reported(run(*plan, Messages(*verbosity)));
}

int run_bench_command(const BenchFlags& flags) {
  choose_process(flags.input);
  const auto verbosity = plan_verbosity(flags.run);
  if (!verbosity) return report(verbosity.error());
  const auto plan = plan_bench(flags);
  if (!plan) return report(plan.error());
  if (!plan->gpu_threads) {
    // To the most that are compared: more of them would start where a comparison of fewer ends.
    auto limited = limit_threads(std::ranges::max(plan->options.threads));
    if (!limited) return report(limited.error());
  }
  return done_or_reported(run_bench(*plan, Messages(*verbosity)));
}

int run_stability_command(const StabilityFlags& flags) {
  const auto verbosity = plan_verbosity(flags.run);
  if (!verbosity) return report(verbosity.error());
  if (auto limited = limit_threads(flags.run.threads); !limited) return report(limited.error());
  return done_or_reported(run_stability(flags, Messages(*verbosity)));
}

int run_convert_command(const ConvertFlags& flags, const std::vector<std::string>& arguments) {
  choose_process(flags.input);
  auto done = is_batch(flags) ? run_batch(flags, arguments) : run_convert(flags, arguments);
  if (!done && done.error().code == ErrorCode::usage && flags.config) {
    done.error().message += fmt::format(" (options come from {}, too)", printable(*flags.config));
  }
  return done_or_reported(done);
}

int run_arguments(const std::vector<std::string>& arguments) {
  const auto line = declare_command_line();
  if (arguments.empty()) {
    fmt::print(stderr, "{}", short_usage(line->app));
    return exit_code_of(ErrorCode::usage);
  }
  std::vector<std::string> options;
  for (const CLI::Option* option : innermost_command_of(*line, arguments).get_options()) {
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  }
  set_options_of_hints(std::move(options));
  const auto parsed = parse_command_line(*line, arguments);
  if (!parsed) {
    if (&command_of(*line, arguments) == line->convert) report_unread_words(arguments, parsed.error());
    return report(parsed.error());
  }
  switch (parsed->request) {
    case Request::version_flag: return print(fmt::format("{}\n", generator()));
    case Request::help_flag:
      return print(parsed->command == &line->app ? help_overview(line->app) : help_of_command(*parsed->command));
    case Request::help:
      return print(line->help_flags.topic ? help_of(line->app, *line->help_flags.topic) : help_overview(line->app));
    case Request::generate:
      if (!line->generate_flags.document) {
        return report({ErrorCode::usage, "generate needs the name of a document", synopsis(*line->generate)});
      }
      return print(generate_document(line->app, *line->generate_flags.document));
    case Request::info: return run_info_command(line->info_flags, *line->info);
    case Request::verify: return plan_and_run(line->verify_flags, plan_verify, run_verify);
    case Request::compare: return plan_and_run(line->compare_flags, plan_compare, run_compare);
    case Request::check: return plan_and_run(line->check_flags, plan_check, run_check);
    case Request::render: return plan_and_run(line->render_flags, plan_render, run_render);
    case Request::bench: return run_bench_command(line->bench_flags);
    case Request::merge: return done_or_reported(run_merge(line->merge_flags));
    case Request::devices: return done_or_reported(run_devices(line->devices_flags));
    case Request::stability: return run_stability_command(line->stability_flags);
    case Request::water: return plan_and_run(line->water_flags, plan_water, run_water);
    case Request::jet: return plan_and_run(line->jet_flags, plan_jet, run_jet);
    case Request::convert: break;
  }
  if (line->convert_flags.config) {
    const auto configured = with_config(*line, arguments);
    if (configured) return run_convert_command(configured->line->convert_flags, configured->arguments);
    report_unread_words(arguments, configured.error());
    return report(configured.error());
  }
  return run_convert_command(line->convert_flags, arguments);
}

// Ends the process as the signal would have, but leaves no unfinished file.
extern "C" void on_end(int signal) {
  files::OutputFile::remove_unfinished();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

// By all signals that are sent to end a process and can be caught: also those of batch queues (SIGXCPU, SIGUSR1,
// SIGUSR2) and timers. What the shell told to ignore (nohup) stays ignored.
void leave_nothing_when_interrupted() {
  for (const int signal : {SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU, SIGALRM, SIGUSR1, SIGUSR2}) {
    if (std::signal(signal, on_end) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

}  // namespace

int run(int argc, char** argv) {
  keep_standard_streams();
  // A closed pipe and a file-size limit are errors of writing, with a message and an exit code.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  leave_nothing_when_interrupted();
  try {
    return run_arguments(std::vector<std::string>(argv + (argc > 0 ? 1 : 0), argv + argc));
  } catch (const std::exception&) {
    return report(error_of_exception());
  }
}

}  // namespace isoextract::cli
