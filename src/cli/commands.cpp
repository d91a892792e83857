#include "cli/commands.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "base/version.hpp"
#include "cli/help_topics.hpp"
#include "cli/messages.hpp"
#include "cli/options/run.hpp"

namespace isoextract::cli {

// Declares functions that the files of the commands define; in a unity build the definition may come first.
// NOLINTBEGIN(readability-redundant-declaration)
using MakeCommand = std::unique_ptr<Command>();
MakeCommand make_convert_command;
MakeCommand make_info_command;
MakeCommand make_verify_command;
MakeCommand make_compare_command;
MakeCommand make_check_command;
MakeCommand make_render_command;
MakeCommand make_bench_command;
MakeCommand make_stability_command;
MakeCommand make_merge_command;
MakeCommand make_devices_command;
MakeCommand make_formats_command;
MakeCommand make_simulate_command;
MakeCommand make_help_command;
MakeCommand make_generate_command;
// NOLINTEND(readability-redundant-declaration)

namespace {

constexpr std::array kCommands{
    make_convert_command, make_info_command,     make_verify_command,    make_compare_command,  make_check_command,
    make_render_command,  make_bench_command,    make_stability_command, make_merge_command,    make_devices_command,
    make_formats_command, make_simulate_command, make_help_command,      make_generate_command,
};

struct ProgramFlags : OptionSet {
  HelpOptions help{*this};
  Flag version{*this, "--version", "Show the version and exit."};
};

class Program final : public CommandOf<ProgramFlags> {
 public:
  Program() : CommandOf({"isoextract", "", "extracts isosurfaces from volumes and particles."}) {
    for (MakeCommand* make : kCommands) add(make());
  }

  Result<int> run(const std::vector<std::string>& arguments) override {
    const auto is_given = [&](const Option& option) {
      return std::ranges::find(arguments, option.name()) != arguments.end();
    };
    TRY(print_to_stdout(is_given(flags().version)    ? fmt::format("{}\n", generator())
                        : is_given(flags().help.all) ? help_of_command(default_command(*this), HelpDetail::all)
                                                     : help_overview(*this)));
    return kDone;
  }
};

}  // namespace

std::unique_ptr<Command> make_program() { return std::make_unique<Program>(); }

}  // namespace isoextract::cli
