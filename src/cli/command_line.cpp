#include "cli/command_line.hpp"

#include <algorithm>
#include <filesystem>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/foreign_words.hpp"
#include "cli/values.hpp"

namespace isoextract::cli {
namespace {

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands_of(app)) names.push_back(command->get_name());
  return names;
}

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string help_hint(const CLI::App& command) {
  return fmt::format("'isoextract {} --help' lists the options", full_name(command));
}

// "-o=a.ply", which CLI11 takes as a file "=a.ply". Of letters in one word, the first that takes a value ends them.
Result<void> check_short_option(const CLI::App& command, const std::string& argument) {
  for (std::size_t at = 1; at < argument.size(); ++at) {
    const std::string name = fmt::format("-{}", argument[at]);
    const CLI::Option* option = command.get_option_no_throw(name);
    if (option == nullptr) return {};
    const bool has_equals = at + 1 < argument.size() && argument[at + 1] == '=';
    if (!takes_value(*option) && has_equals) return fail(ErrorCode::usage, fmt::format("{} takes no value", name));
    if (takes_value(*option) && has_equals) {
      const std::string value = argument.substr(at + 2);
      return fail(
          ErrorCode::usage, fmt::format("{}: {} takes no '='", argument, name),
          fmt::format("write {} {} or {}={}", name, shell_quoted(value), option->get_name(), shell_quoted(value)));
    }
    if (takes_value(*option)) return {};
  }
  return {};
}

// "--name=..." where the option takes no value, and "--name=" where it takes one: CLI11 would take the former as a
// truth value, and the next word as the value of the latter.
Result<void> check_equals_signs(const CLI::App& command, const std::vector<std::string>& arguments) {
  for (const std::string& argument : arguments) {
    if (argument == "--") break;
    if (argument.starts_with('-') && !argument.starts_with("--")) {
      TRY(check_short_option(command, argument));
    }
    const std::size_t equals = argument.find('=');
    if (!argument.starts_with("--") || equals == std::string::npos) continue;
    const std::string name = argument.substr(0, equals);
    const CLI::Option* option = command.get_option_no_throw(name);
    if (option == nullptr) continue;
    if (!takes_value(*option)) return fail(ErrorCode::usage, fmt::format("{} takes no value", name));
    if (equals + 1 == argument.size()) {
      return fail(ErrorCode::usage, fmt::format("{} needs a value: {}", name, spelling(*option)));
    }
  }
  return {};
}

// An option whose value may be left out takes the next word only if that is one of its values, or a
// number where it has no list of them: an INPUT may follow it.
void fill_in_optional_values(const CLI::App& command, std::vector<std::string>& arguments) {
  for (std::size_t a = 0; a < arguments.size() && arguments[a] != "--"; ++a) {
    const CLI::Option* option = arguments[a].starts_with("--") ? command.get_option_no_throw(arguments[a]) : nullptr;
    if (option == nullptr || !value_is_optional(*option)) continue;
    const std::vector<std::string> values = choices(*option);
    const std::string next = a + 1 == arguments.size() ? "" : arguments[a + 1];
    const bool is_number = !next.empty() && next.find_first_not_of("0123456789") == std::string::npos;
    const bool is_value = values.empty() ? is_number : contains(values, next);
    if (!is_value) arguments[a] += "=" + (values.empty() ? option->get_default_str() : values.front());
  }
}

bool takes_inputs(const CommandLine& line, const CLI::App& command) {
  return &command == line.convert || &command == line.info || &command == line.compare || &command == line.check ||
         &command == line.render || &command == line.bench || &command == line.verify;
}

// The volume, then the mesh.
bool take_verify_input(VerifyFlags& flags, const std::string& word) {
  if (flags.conversion.input.inputs.empty()) {
    flags.conversion.input.inputs.push_back(word);
  } else if (!flags.mesh) {
    flags.mesh = word;
  } else {
    return false;
  }
  return true;
}

// CLI11 hands over one INPUT and leaves the others, as it splits the words of lists: "[a,b]" would be two files.
// Returns whether the command takes `word`.
bool take_input(CommandLine& line, const CLI::App* command, const std::string& word) {
  if (command == line.convert) line.convert_flags.input.inputs.push_back(word);
  if (command == line.info) line.info_flags.input.inputs.push_back(word);
  if (command == line.compare) line.compare_flags.meshes.push_back(word);
  if (command == line.check) line.check_flags.meshes.push_back(word);
  if (command == line.render) line.render_flags.input.inputs.push_back(word);
  if (command == line.bench) line.bench_flags.input.inputs.push_back(word);
  if (command == line.verify) return take_verify_input(line.verify_flags, word);
  return takes_inputs(line, *command);
}

// What follows "--" are inputs, whatever they look like. A word that is an option, and no file of that name, was meant
// as one.
Result<void> take_trailing(CommandLine& line, const CLI::App& command, std::span<const std::string> words) {
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    std::error_code unknown;
    if (name.starts_with('-') && command.get_option_no_throw(name) != nullptr &&
        !std::filesystem::exists(word, unknown)) {
      return fail(ErrorCode::usage, fmt::format("'{}' comes after '--', where all words are names of files", word),
                  "options come before '--'");
    }
    if (!take_input(line, &command, word)) {
      return fail(ErrorCode::usage, fmt::format("unexpected argument '{}'", word), help_hint(command));
    }
  }
  return {};
}

// What CLI11 left over: further inputs, and words that nobody knows.
Result<void> take_remaining(CommandLine& line, const CLI::App& command) {
  for (const std::string& word : command.remaining()) {
    if (word == "--") continue;  // of a command without inputs: CLI11 keeps it although it has done its work
    if (!word.starts_with('-') || word == "-") {
      if (take_input(line, &command, word)) continue;
      return fail(ErrorCode::usage, fmt::format("unexpected argument '{}'", word), help_hint(command));
    }
    const std::string name = word.substr(0, word.find('='));
    std::vector<std::string> known;
    for (const CLI::App* declaring : {&command, static_cast<const CLI::App*>(&line.app)}) {
      for (const CLI::Option* option : declaring->get_options()) {
        for (const std::string& long_name : option->get_lnames()) known.push_back("--" + long_name);
      }
    }
    const std::string near = name.starts_with("--") ? nearest_name(name, known) : "";
    std::error_code none;
    const bool is_file = takes_inputs(line, command) && std::filesystem::exists(word, none);
    std::string meant = hint_for_foreign_option(command, name);
    if (meant.empty() && near.empty() && line.convert->get_option_no_throw(name) != nullptr) {
      meant = &command == line.verify ? fmt::format(
                                            "leave {} out: of convert's options verify has those that decide "
                                            "about the triangles of a mesh",
                                            name)
                                      : fmt::format("{} is an option of convert; {}", name, help_hint(command));
    }
    return fail(ErrorCode::usage, fmt::format("unknown option '{}' for '{}'", name, full_name(command)),
                is_file          ? fmt::format("the file of that name is written {}", shell_quoted("./" + word))
                : !meant.empty() ? meant
                : !near.empty()  ? fmt::format("did you mean '{}'?", near)
                                 : help_hint(command));
  }
  return {};
}

// Why CLI11 stopped, in terms of the declarations: its own texts name types that say nothing to a user.
tl::unexpected<Error> explain(const CLI::ParseError& error, const CLI::App& command, const std::string& last_argument) {
  for (const CLI::Option* option : command.get_options()) {
    const bool repeatable = option->get_items_expected_max() > 1;
    if (option->count() > 1 && takes_value(*option) && !repeatable) {
      return fail(ErrorCode::usage,
                  fmt::format("{} was given {} times; it takes one value",
                              option->get_positional() ? spelling(*option) : option->get_name(), option->count()));
    }
  }
  const CLI::Option* last = last_argument.starts_with('-') ? command.get_option_no_throw(last_argument) : nullptr;
  if (last != nullptr && takes_value(*last)) {
    return fail(ErrorCode::usage, fmt::format("{} needs a value: {}", last_argument, spelling(*last)));
  }
  return fail(ErrorCode::usage, error.what(), help_hint(command));
}

Request request_of(const CommandLine& line, const CLI::App* command) {
  if (command == line.info) return Request::info;
  if (command == line.verify) return Request::verify;
  if (command == line.compare) return Request::compare;
  if (command == line.check) return Request::check;
  if (command == line.render) return Request::render;
  if (command == line.bench) return Request::bench;
  if (command == line.stability) return Request::stability;
  if (command == line.devices) return Request::devices;
  if (command == line.merge) return Request::merge;
  if (command == line.simulate_water) return Request::water;
  if (command == line.simulate_jet) return Request::jet;
  if (command == line.help) return Request::help;
  if (command == line.generate) return Request::generate;
  return Request::convert;
}

// Of a command that has sub-commands the one that the second word names, unless that asks for help.
Result<const CLI::App*> inner_command(const CLI::App& command, const std::vector<std::string>& arguments) {
  const std::vector<std::string> names = command_names(command);
  if (names.empty()) return &command;
  if (arguments.size() == 1) {
    return fail(ErrorCode::usage,
                fmt::format("{} needs one of {} after it", command.get_name(), fmt::join(names, ", ")),
                synopsis(command));
  }
  const std::string& word = arguments[1];
  if (command.get_help_ptr()->check_name(word)) return &command;
  if (contains(names, word)) return command.get_subcommand(word);
  const std::string near = nearest_name(word, names);
  return fail(ErrorCode::usage,
              fmt::format("{}: expected one of {}, found '{}'", command.get_name(), fmt::join(names, ", "), word),
              near.empty() ? synopsis(command) : fmt::format("did you mean '{}'?", near));
}

}  // namespace

const CLI::App& command_of(const CommandLine& line, const std::vector<std::string>& arguments) {
  const bool named = !arguments.empty() && contains(command_names(line.app), arguments.front());
  return named ? *line.app.get_subcommand(arguments.front()) : *line.convert;
}

const CLI::App& innermost_command_of(const CommandLine& line, const std::vector<std::string>& arguments) {
  const CLI::App& command = command_of(line, arguments);
  const bool named = arguments.size() > 1 && contains(command_names(command), arguments[1]);
  return named ? *command.get_subcommand(arguments[1]) : command;
}

Result<Parsed> parse_command_line(CommandLine& line, std::vector<std::string> arguments) {
  const std::vector<std::string> names = command_names(line.app);
  const std::string first = arguments.front();
  const bool asks_program = line.app.get_help_ptr()->check_name(first) || line.app.get_version_ptr()->check_name(first);
  if (!asks_program && !contains(names, first)) arguments.insert(arguments.begin(), "convert");
  const CLI::App* command = &line.app;
  if (!asks_program) {
    command = TRY(inner_command(*line.app.get_subcommand(arguments.front()), arguments));
  }

  TRY(check_equals_signs(*command, arguments));
  fill_in_optional_values(*command, arguments);
  std::vector<std::string> trailing;
  if (const auto dashes = std::ranges::find(arguments, "--");
      takes_inputs(line, *command) && dashes != arguments.end()) {
    trailing.assign(dashes + 1, arguments.end());
    arguments.erase(dashes, arguments.end());
  }
  try {
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());  // as CLI11 wants them
    line.app.parse(reversed);
  } catch (const CLI::CallForVersion&) {
    return Parsed{Request::version_flag, command};
  } catch (const CLI::ParseError& error) {
    if (command->get_help_ptr()->count() > 0) return Parsed{Request::help_flag, command};
    TRY(take_remaining(line, *command));
    if (const auto* bad_value = dynamic_cast<const BadValue*>(&error)) return tl::unexpected(bad_value->error);
    return explain(error, *command, arguments.back());
  }
  TRY(take_remaining(line, *command));
  TRY(take_trailing(line, *command, trailing));

  // A misspelt command looks like a second input.
  const std::vector<std::string>& inputs = line.convert_flags.input.inputs;
  if (command == line.convert && inputs.size() > 1 && !std::filesystem::exists(inputs.front())) {
    const std::string near = nearest_name(inputs.front(), names);
    if (!near.empty()) {
      return fail(ErrorCode::usage, fmt::format("'{}' is neither a command nor a file", inputs.front()),
                  fmt::format("did you mean 'isoextract {}'?", near));
    }
  }
  if (command == line.convert) {
    TRY(check_for_output_among_inputs(line.convert_flags));
  }
  return Parsed{request_of(line, command), command};
}

}  // namespace isoextract::cli
