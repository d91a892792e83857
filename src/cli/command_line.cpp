#include "cli/command_line.hpp"

#include <algorithm>
#include <filesystem>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/nearest_name.hpp"
#include "cli/foreign_options.hpp"
#include "cli/parser.hpp"
#include "cli/values.hpp"

namespace isoextract::cli {
namespace {

// Returns "--iso" for "--iso=0.5".
std::string name_in(const std::string& word) { return word.substr(0, word.find('=')); }

// Refuses "-o=a.ply", which CLI11 would read as the file "=a.ply". In a word of several letters, the first option that
// takes a value ends the letters.
Result<void> check_short_option(const OptionSet& options, const std::string& word) {
  for (std::size_t at = 1; at < word.size(); ++at) {
    const std::string name = fmt::format("-{}", word[at]);
    const Option* option = options.find(name);
    if (option == nullptr) return {};
    const bool has_equals = at + 1 < word.size() && word[at + 1] == '=';
    if (!option->takes_value() && has_equals) return fail(ErrorCode::usage, fmt::format("{} takes no value", name));
    if (option->takes_value() && has_equals) {
      const std::string value = word.substr(at + 2);
      return fail(ErrorCode::usage, fmt::format("{}: {} takes no '='", word, name),
                  fmt::format("write {} {} or {}={}", name, shell_quoted(value), option->name(), shell_quoted(value)));
    }
    if (option->takes_value()) return {};
  }
  return {};
}

// Refuses "--name=..." if the option takes no value, and "--name=" if it takes one. CLI11 would read the former as a
// boolean, and take the next word as the value of the latter.
Result<void> check_equals_sign(const OptionSet& options, const std::string& word) {
  if (word.starts_with('-') && !word.starts_with("--")) return check_short_option(options, word);
  const std::string name = name_in(word);
  const Option* option = name.size() == word.size() ? nullptr : options.find(name);
  if (option == nullptr) return {};
  if (!option->takes_value()) return fail(ErrorCode::usage, fmt::format("{} takes no value", name));
  if (name.size() + 1 < word.size()) return {};
  return fail(ErrorCode::usage, fmt::format("{} needs a value: {}", name, option->spelling()));
}

Result<void> check_equals_signs(const OptionSet& options, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (word == "--") break;
    TRY(check_equals_sign(options, word));
  }
  return {};
}

// Inserts omitted optional values. Such an option takes the next word only if that is one of its values, or a number if
// it has no list of values, because an INPUT may follow it.
void fill_in_optional_values(const OptionSet& options, std::vector<std::string>& words) {
  for (std::size_t w = 0; w < words.size() && words[w] != "--"; ++w) {
    const Option* option = words[w].starts_with("--") ? options.find(words[w]) : nullptr;
    if (option == nullptr || !option->row().left_out) continue;
    const std::vector<std::string> values = option->choices();
    const std::string next = w + 1 == words.size() ? "" : words[w + 1];
    const bool is_number = !next.empty() && next.find_first_not_of("0123456789") == std::string::npos;
    const bool is_value = values.empty() ? is_number : std::ranges::find(values, next) != values.end();
    if (!is_value) words[w] += "=" + (values.empty() ? *option->row().left_out : values.front());
  }
}

bool takes_files(const OptionSet& options) {
  const Option* const operand = options.operand();
  return operand != nullptr && operand->takes_file();
}

// Adds a word to the operand, because CLI11 delivers only the first word of the operand.
Result<void> take_file(const Command& command, const std::string& word) {
  const bool takes_them = takes_files(command.options());
  for (Option* option : command.options().options()) {
    if (!takes_them || !option->is_positional() || option->texts().size() >= option->row().most) continue;
    option->add_text(word);
    return {};
  }
  return fail(ErrorCode::usage, fmt::format("unexpected argument '{}'", word), help_hint(command));
}

// Takes the words after "--" as inputs. Refuses a word that is an option's name and not an existing file, since it was
// probably meant as an option.
Result<void> take_trailing(const Command& command, std::span<const std::string> words) {
  for (const std::string& word : words) {
    std::error_code unknown;
    if (command.options().find(name_in(word)) != nullptr && !std::filesystem::exists(word, unknown)) {
      return fail(ErrorCode::usage, fmt::format("'{}' comes after '--', where every word is a file name", word),
                  "put options before '--'");
    }
    TRY(take_file(command, word));
  }
  return {};
}

tl::unexpected<Error> unknown_option(const Command& command, const std::string& word) {
  const std::string name = name_in(word);
  std::vector<std::string> known;
  for (const OptionSet* declaring : {&command.options(), &command.program().options()}) {
    for (const Option* option : declaring->options()) {
      if (!option->is_positional()) known.push_back(option->name());
    }
  }
  const std::string near = name.starts_with("--") ? nearest_name(name, known) : "";
  std::error_code none;
  const bool is_file = takes_files(command.options()) && std::filesystem::exists(word, none);
  std::string meant = hint_for_other_programs_option(command.options(), name);
  if (meant.empty() && near.empty() && default_command(command.program()).options().find(name) != nullptr) {
    meant = command.hint_for_default_command_option(name);
  }
  return fail(ErrorCode::usage, fmt::format("unknown option '{}' for '{}'", name, command.full_name()),
              is_file          ? fmt::format("to name the file, write {}", shell_quoted("./" + word))
              : !meant.empty() ? meant
              : !near.empty()  ? fmt::format("did you mean '{}'?", near)
                               : help_hint(command));
}

// Takes the remaining words as further inputs, or refuses them.
Result<void> take_rest(const Command& command, const std::vector<std::string>& rest) {
  for (const std::string& word : rest) {
    if (word == "--") continue;  // CLI11 leaves it in the words of a command without inputs
    if (word.starts_with('-') && word != "-") return unknown_option(command, word);
    TRY(take_file(command, word));
  }
  return {};
}

Result<void> check_given_once(const Option& option) {
  if (option.texts().size() < 2 || !option.takes_value() || option.is_repeatable()) return {};
  return fail(ErrorCode::usage,
              fmt::format("{} takes one value, found {}", option.is_positional() ? option.spelling() : option.name(),
                          option.texts().size()));
}

// Explains a parse failure in the terms of the declared options. CLI11's own texts name types that users do not know.
Result<void> explain(const std::string& problem, const Command& command, const std::string& last_word) {
  for (const Option* option : command.options().options()) {
    TRY(check_given_once(*option));
  }
  const Option* last = command.options().find(last_word);
  if (last != nullptr && last->takes_value()) {
    return fail(ErrorCode::usage, fmt::format("{} needs a value: {}", last_word, last->spelling()));
  }
  return fail(ErrorCode::usage, problem, help_hint(command));
}

Result<void> take_values(OptionSet& options) {
  for (Option* option : options.options()) {
    TRY(check_given_once(*option));
    TRY(option->take());
  }
  return {};
}

// Refuses an unknown sub-command.
Result<void> check_inner_name(const Command& command, const std::vector<std::string>& words) {
  if (command.inner().empty() || words.empty()) return {};
  const Option* const option = command.options().find(words.front());
  if (option != nullptr && option->help()) return {};
  const std::vector<std::string> names = command.inner_names();
  const std::string near = nearest_name(words.front(), names);
  return fail(ErrorCode::usage,
              fmt::format("{}: expected one of {}, found '{}'", command.name(), fmt::join(names, ", "), words.front()),
              near.empty() ? command.synopsis() : fmt::format("did you mean '{}'?", near));
}

// Refuses a first input that is not a file and resembles a command's name.
Result<void> check_first_input(const Command& command) {
  const std::vector<std::string>& inputs = command.options().operand()->texts();
  std::error_code error;  // such as a loop of links: reading the input reports it
  if (inputs.empty() || std::filesystem::exists(inputs.front(), error) || error) return {};
  const std::string near = nearest_name(inputs.front(), command.program().inner_names());
  if (near.empty()) return {};
  return fail(ErrorCode::usage, fmt::format("'{}' is neither a command nor a file", inputs.front()),
              fmt::format("did you mean 'isoextract {}'?", near));
}

}  // namespace

Command& find_command(const Command& program, const std::vector<std::string>& arguments) {
  Command* const named = arguments.empty() ? nullptr : program.find(arguments.front());
  return named != nullptr ? *named : *program.inner().front();
}

Command& find_subcommand(const Command& program, const std::vector<std::string>& arguments) {
  Command& command = find_command(program, arguments);
  Command* const inner = arguments.size() > 1 ? command.find(arguments[1]) : nullptr;
  return inner != nullptr ? *inner : command;
}

std::vector<std::string> arguments_after_command(const Command& command, const std::vector<std::string>& arguments) {
  const std::vector<std::string> path = command.path();
  const auto [after, end] = std::ranges::mismatch(arguments, path);
  return {end == path.end() ? after : arguments.begin(), arguments.end()};
}

Result<Parsed> parse_command_line(Command& program, const std::vector<std::string>& arguments) {
  if (program.options().find(arguments.front()) != nullptr) {
    TRY(check_equals_signs(program.options(), arguments));
    return Parsed{&program, std::nullopt};
  }
  Command& command = find_subcommand(program, arguments);
  const std::vector<std::string> words = arguments_after_command(command, arguments);
  TRY(check_inner_name(command, words));
  TRY(parse_words(command, words));
  if (const auto help = command.help_asked()) return Parsed{&command, help};
  if (command.is_default()) {
    TRY(check_first_input(command));
  }
  TRY(command.check_words());
  return Parsed{&command, std::nullopt};
}

Result<void> parse_words(Command& command, std::vector<std::string> words) {
  OptionSet& options = command.options();
  TRY(check_equals_signs(options, words));
  fill_in_optional_values(options, words);
  std::vector<std::string> trailing;
  if (const auto dashes = std::ranges::find(words, "--"); takes_files(options) && dashes != words.end()) {
    trailing.assign(dashes + 1, words.end());
    words.erase(dashes, words.end());
  }
  const ReadWords read = read_words(options, words);
  if (command.help_asked()) return {};
  TRY(take_rest(command, read.rest));
  if (!read.problem.empty()) return explain(read.problem, command, words.back());
  TRY(take_values(options));
  TRY(take_trailing(command, trailing));
  return take_values(options);
}

void read_words_leniently(Command& command, const std::vector<std::string>& words) {
  OptionSet& options = command.options();
  std::vector<std::string> readable;
  std::vector<std::string> rest;
  for (std::size_t w = 0; w < words.size(); ++w) {
    const Option* const option = options.find(words[w]);
    // An option without its value would take the next option as its value.
    const bool needs_value = option != nullptr && option->takes_value() && !option->row().left_out;
    const bool lacks_value = needs_value && (w + 1 == words.size() || options.find(name_in(words[w + 1])) != nullptr);
    if (lacks_value || words[w] == "--") continue;
    (check_equals_sign(options, words[w]) ? readable : rest).push_back(words[w]);
  }
  fill_in_optional_values(options, readable);
  const ReadWords read = read_words(options, readable);
  rest.insert(rest.begin(), read.rest.begin(), read.rest.end());
  for (const std::string& word : rest) {
    // "-o=a.ply" and "--unknown=a.ply" may name a file behind the "=".
    const std::size_t equals = word.starts_with('-') ? word.find('=') : std::string::npos;
    [[maybe_unused]] const auto taken =
        take_file(command, equals == std::string::npos ? word : word.substr(equals + 1));
  }
  for (Option* option : options.options()) [[maybe_unused]] const auto taken = option->take();
}

}  // namespace isoextract::cli
