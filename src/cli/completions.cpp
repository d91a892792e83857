// Completion scripts for bash, zsh and fish. Each script completes commands, options (also of the default command) and
// option values: words, files or nothing.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/command.hpp"
#include "cli/generate_docs.hpp"
#include "cli/layout.hpp"
#include "field/demo_field.hpp"

namespace isoextract::cli {
namespace {

// Returns the option's names with their dashes.
std::vector<std::string> dashed_names(const Option& option) {
  return option.is_positional() ? std::vector<std::string>() : option.row().names;
}

std::vector<std::string> demo_names() {
  std::vector<std::string> names;
  for (const field::DemoDescription& demo : field::demo_fields())
    names.push_back(fmt::format("{}{}", field::kDemoPrefix, demo.name));
  return names;
}

// Returns the summary of an option or a command, without a full stop.
std::string short_text(std::string_view help) {
  std::string text = first_sentence(help);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
  return text;
}

// Returns the name of the script's function for the command: "simulate_water".
std::string function_name(const Command& command) { return replaced(command.full_name(), " ", "_"); }

// Returns the commands of two words, quoted: "'simulate water'".
std::vector<std::string> quoted_inner_names(const Command& program) {
  std::vector<std::string> names;
  for (const Command* command : all_commands(program)) {
    if (command->path().size() > 1) names.push_back(fmt::format("'{}'", command->full_name()));
  }
  return names;
}

// bash ------------------------------------------------------------------------------------------------------------

// Returns the possible words after each option of `command`, as branches of a case.
std::string bash_values(const Command& command) {
  std::string out;
  for (const Option* option : command.options().options()) {
    if (option->is_positional() || !option->takes_value()) continue;
    std::vector<std::string> values = option->choices();
    if (option->takes_file()) values.insert(values.begin(), "@files");
    if (values.empty()) values.emplace_back("@nothing");
    out += fmt::format("        {}) values=\"{}\" ;;\n", fmt::join(dashed_names(*option), "|"), fmt::join(values, " "));
  }
  return out;
}

std::string bash_command(const Command& command) {
  std::vector<std::string> options;
  for (const Option* option : command.options().options()) {
    for (std::string& word : dashed_names(*option)) options.push_back(std::move(word));
  }
  const Option* operand = command.options().operand();
  std::vector<std::string> values = operand == nullptr ? command.inner_names() : operand->choices();
  return fmt::format(
      "    '{}')\n"
      "      options=\"{}\"\n"
      "      words=\"{}\"\n"
      "      case $previous in\n"
      "{}"
      "      esac\n"
      "      ;;\n",
      command.full_name(), fmt::join(options, " "),
      values.empty() ? "@files" : fmt::format("{}", fmt::join(values, " ")), bash_values(command));
}

// zsh -------------------------------------------------------------------------------------------------------------

std::string zsh_escaped(const std::string& text) {
  return replaced(replaced(replaced(replaced(text, "'", "'\\''"), "[", "\\["), "]", "\\]"), ":", "\\:");
}

std::string zsh_action(const Option& option) {
  const std::vector<std::string> values = option.choices();
  if (!values.empty()) {
    // The space before the function keeps zsh from adding arguments of its own.
    return option.takes_file() ? fmt::format(":value: _isoextract_files_or {}", fmt::join(values, " "))
                               : fmt::format(":value:({})", fmt::join(values, " "));
  }
  if (option.is_positional()) return ":input:_isoextract_inputs";
  return option.takes_file() ? ":file:_files" : fmt::format(":{}: ", zsh_escaped(option.row().metavar));
}

// Returns the zsh code that chooses an inner command of `outer` by the word after the name of `outer`.
std::string zsh_choice(const Command& outer) {
  std::string described;
  std::string branches;
  for (const auto& command : outer.inner()) {
    described += fmt::format("      '{}:{}'\n", command->name(), zsh_escaped(command->summary()));
    if (command->is_default()) continue;
    branches += fmt::format("    {}) shift words; (( CURRENT-- )); _isoextract_{} ;;\n", command->name(),
                            function_name(*command));
  }
  return fmt::format(R"(  if (( CURRENT == 2 )); then
    local -a commands=(
{}    )
    _describe 'command' commands
  fi
  case $words[2] in
{})",
                     described, branches);
}

std::string zsh_command(const Command& command) {
  if (!command.inner().empty()) {
    return fmt::format("_isoextract_{}() {{\n{}  esac\n}}\n\n", function_name(command), zsh_choice(command));
  }
  std::string out = fmt::format("_isoextract_{}() {{\n  _arguments -s -S", function_name(command));
  for (const Option* option : command.options().options()) {
    if (option->is_positional()) {
      if (option == command.options().operand()) out += fmt::format(" \\\n    '*{}'", zsh_action(*option));
      continue;
    }
    const bool repeatable = option->is_repeatable();
    for (const std::string& word : dashed_names(*option)) {
      const bool has_equals = option->takes_value() && word.starts_with("--");
      out += fmt::format(" \\\n    '{}{}{}[{}]{}'", repeatable ? "*" : "", word, has_equals ? "=" : "",
                         zsh_escaped(short_text(option->row().help)), option->takes_value() ? zsh_action(*option) : "");
    }
  }
  return out + "\n}\n\n";
}

// fish ------------------------------------------------------------------------------------------------------------

std::string fish_quoted(const std::string& text) {
  return "'" + replaced(replaced(text, "\\", "\\\\"), "'", "\\'") + "'";
}

std::string fish_option(const Command& command, const Option& option) {
  std::string line = fmt::format("complete -c isoextract -n '__isoextract_command_is {}'", command.full_name());
  for (const std::string& name : option.row().names) {
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  const std::vector<std::string> values = option.choices();
  if (option.takes_value()) line += option.takes_file() ? " -r -F" : " -x";
  if (!values.empty()) line += fmt::format(" -a '{}'", fmt::join(values, " "));
  return line + " -d " + fish_quoted(short_text(option.row().help)) + "\n";
}

std::string fish_positional(const Command& command, const Option& option) {
  const std::vector<std::string> values = option.choices();
  return fmt::format("complete -c isoextract -n '__isoextract_command_is {}' {} -a '{}'\n", command.full_name(),
                     values.empty() ? "-F" : "-f", fmt::join(values.empty() ? demo_names() : values, " "));
}

}  // namespace

std::string bash_completion(const Command& program) {
  std::vector<std::string> other_options;  // options that are given without a command
  for (const Option* option : program.options().options()) {
    if (!option->help()) other_options.push_back(option->name());
  }
  std::string commands;
  for (const Command* command : all_commands(program)) commands += bash_command(*command);
  return fmt::format(R"(# bash completion of isoextract. Made by 'isoextract generate bash'; do not edit.

_isoextract() {{
  # Words as the shell splits them at spaces only: bash also breaks at ':' and '='.
  local line=${{COMP_LINE:0:COMP_POINT}}
  local current=${{line##*[[:space:]]}}
  local rest=${{line%"$current"}}
  rest=${{rest%"${{rest##*[![:space:]]}}"}}
  local previous=${{rest##*[[:space:]]}}
  local given=$current

  local command={6} first
  read -r _ first _ <<<"$line"
  local is_first=no
  [[ $rest != *[[:space:]]* ]] && is_first=yes
  if [[ $is_first == no ]]; then
    case $first in
      {0}) command=$first ;;
    esac
    local second
    read -r _ _ second _ <<<"$rest"
    case "$first $second" in
      {5}) command="$first $second" ;;
    esac
  fi
  if [[ $current == --*=* ]]; then
    previous=${{current%%=*}}
    current=${{current#*=}}
  fi

  local options words values=
  case $command in
{1}  esac

  COMPREPLY=()
  local candidates=$values
  if [[ -z $values ]]; then
    if [[ $current == -* ]]; then
      candidates=$options
    elif [[ $words != @files ]]; then
      candidates=$words
    elif [[ $current == demo* ]]; then
      candidates="{2}"
    else
      candidates=@files
      [[ $is_first == yes ]] && COMPREPLY=($(compgen -W "{3}" -- "$current"))
    fi
    [[ $is_first == yes && $current == -* ]] && candidates="$options {4}"
  fi

  case $candidates in
    @nothing) return ;;
    @files*)
      COMPREPLY+=($(compgen -W "${{candidates#@files}}" -- "$current"))
      compopt -o filenames 2>/dev/null
      local file
      while IFS= read -r file; do
        COMPREPLY+=("$file")
      done < <(compgen -f -- "$current")
      return
      ;;
  esac
  COMPREPLY+=($(compgen -W "$candidates" -- "$current"))

  # Where bash breaks the word, only what follows the break is replaced.
  local break
  for break in = :; do
    if [[ $given == *"$break"* && $COMP_WORDBREAKS == *"$break"* ]]; then
      local kept=${{given%"${{given##*"$break"}}"}}
      [[ $break == = ]] && kept=
      COMPREPLY=("${{COMPREPLY[@]#"$kept"}}")
    fi
  done
}}

complete -F _isoextract isoextract
)",
                     fmt::join(program.inner_names(), "|"), commands, fmt::join(demo_names(), " "),
                     fmt::join(program.inner_names(), " "), fmt::join(other_options, " "),
                     fmt::join(quoted_inner_names(program), "|"), default_command(program).name());
}

std::string zsh_completion(const Command& program) {
  std::string functions;
  for (const Command* command : all_commands(program)) functions += zsh_command(*command);
  return fmt::format(R"(#compdef isoextract
# zsh completion of isoextract. Made by 'isoextract generate zsh'; do not edit.

_isoextract_inputs() {{
  local -a demos=({0})
  _alternative 'files:volume:_files' 'demos:demo field:compadd -a demos'
}}

_isoextract_files_or() {{
  local -a choices=("$@")
  _alternative 'choices:value:compadd -a choices' 'files:file:_files'
}}

{1}_isoextract() {{
{2}    {3}) shift words; (( CURRENT-- )); _isoextract_{3} ;;
    *) _isoextract_{3} ;;
  esac
}}

_isoextract "$@"
)",
                     fmt::join(demo_names(), " "), functions, zsh_choice(program), default_command(program).name());
}

std::string fish_completion(const Command& program) {
  std::string out = fmt::format(R"(# fish completion of isoextract. Made by 'isoextract generate fish'; do not edit.

function __isoextract_command_is
    set -l words (commandline -opc)
    set -l command {2}
    if set -q words[2]; and contains -- $words[2] {0}
        set command $words[2]
    end
    if set -q words[3]; and contains -- "$words[2] $words[3]" {1}
        set command "$words[2] $words[3]"
    end
    test $command = "$argv"
end

function __isoextract_first_word
    test (count (commandline -opc)) -eq 1
end

complete -c isoextract -f
)",
                                fmt::join(program.inner_names(), " "), fmt::join(quoted_inner_names(program), " "),
                                default_command(program).name());
  for (const auto& command : program.inner()) {
    out += fmt::format("complete -c isoextract -n __isoextract_first_word -a {} -d {}\n", command->name(),
                       fish_quoted(short_text(command->summary())));
  }
  for (const Option* option : program.options().options()) {
    if (option->help()) continue;
    out += fmt::format("complete -c isoextract -n __isoextract_first_word -l {} -d {}\n", option->key(),
                       fish_quoted(short_text(option->row().help)));
  }
  for (const Command* command : all_commands(program)) {
    for (const auto& inner : command->inner()) {
      out += fmt::format("complete -c isoextract -n '__isoextract_command_is {}' -f -a {} -d {}\n",
                         command->full_name(), inner->name(), fish_quoted(short_text(inner->summary())));
    }
    for (const Option* option : command->options().options()) {
      out += option->is_positional() ? fish_positional(*command, *option) : fish_option(*command, *option);
    }
  }
  return out;
}

}  // namespace isoextract::cli
