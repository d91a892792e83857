#include "cli/parser.hpp"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

namespace isoextract::cli {
namespace {

// Accepts every value as text, also more than the option takes; the option checks them itself.
CLI::Option* declare(CLI::App& command, const Option& option) {
  const std::string names = fmt::format("{}", fmt::join(option.row().names, ","));
  CLI::Option* declared = option.takes_value() ? command.add_option(names) : command.add_flag(names);
  declared->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  if (!option.takes_value()) return declared->disable_flag_override();
  declared->type_name(option.row().metavar);
  if (option.is_repeatable()) declared->expected(1, CLI::detail::expected_max_vector_size)->allow_extra_args(false);
  if (option.row().left_out) declared->expected(0, 1);
  return declared;
}

}  // namespace

ReadWords read_words(OptionSet& options, const std::vector<std::string>& words) {
  CLI::App program;
  program.set_help_flag();  // removes CLI11's own help option
  program.allow_extras();
  program.require_subcommand(1);
  CLI::App& command = *program.add_subcommand("command");
  command.allow_extras();
  std::vector<std::pair<Option*, const CLI::Option*>> declared;
  for (Option* option : options.options()) declared.emplace_back(option, declare(command, *option));

  std::vector<std::string> reversed(words.rbegin(), words.rend());  // CLI11 expects reverse order
  reversed.push_back(command.get_name());
  ReadWords read;
  try {
    program.parse(reversed);
  } catch (const CLI::ParseError& error) {
    read.problem = error.what();
  }
  for (const auto& [option, given] : declared) {
    for (const std::string& text : given->results()) option->add_text(text);
  }
  read.rest = command.remaining();
  return read;
}

}  // namespace isoextract::cli
