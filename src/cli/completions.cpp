// Completion scripts for bash, zsh and fish. All three know the commands, that "convert" is meant where none is given,
// and for each option its values, files, or that nothing can be said.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/generate_docs.hpp"
#include "cli/options.hpp"
#include "field/demo_field.hpp"

namespace isoextract::cli {
namespace {

std::vector<std::string> words_of(const CLI::Option& option) {
  std::vector<std::string> words;
  for (const std::string& name : option.get_snames()) words.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) words.push_back("--" + name);
  return words;
}

bool takes_file(const CLI::Option& option) {
  const std::string metavar = option.get_type_name();
  return metavar == "FILE" || metavar == "INPUT" || metavar == "INPUT...";
}

std::vector<std::string> demo_names() {
  std::vector<std::string> names;
  for (const field::DemoDescription& demo : field::demo_fields())
    names.push_back(fmt::format("{}{}", field::kDemoPrefix, demo.name));
  return names;
}

// The first sentence, which has to do where space is short.
std::string first_sentence(const std::string& description) {
  const std::size_t stop = std::min({description.find(". "), description.find(" ("), description.find("; ")});
  std::string text = description.substr(0, stop);
  if (!text.empty() && text.back() == '.') text.pop_back();
  return text;
}

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
  return text;
}

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands_of(app)) names.push_back(command->get_name());
  return names;
}

// What a script's function for the command is called: "simulate_water".
std::string function_name(const CLI::App& command) { return replaced(full_name(command), " ", "_"); }

// "'simulate water'": of the commands that are two words.
std::vector<std::string> quoted_inner_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : all_commands(app)) {
    if (command->get_parent() != &app) names.push_back(fmt::format("'{}'", full_name(*command)));
  }
  return names;
}

const CLI::Option* positional_of(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) return option;
  }
  return nullptr;
}

// bash ------------------------------------------------------------------------------------------------------------

// What the word after an option of `command` can be, as branches of a case.
std::string bash_values(const CLI::App& command) {
  std::string out;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional() || !takes_value(*option)) continue;
    const std::vector<std::string> values = choices(*option);
    const std::string action = !values.empty()       ? fmt::format("values=\"{}\"", fmt::join(values, " "))
                               : takes_file(*option) ? "values=@files"
                                                     : "values=@nothing";
    out += fmt::format("        {}) {} ;;\n", fmt::join(words_of(*option), "|"), action);
  }
  return out;
}

std::string bash_command(const CLI::App& command) {
  std::vector<std::string> options;
  for (const CLI::Option* option : command.get_options()) {
    for (std::string& word : words_of(*option)) options.push_back(std::move(word));
  }
  const CLI::Option* positional = positional_of(command);
  std::vector<std::string> values = positional == nullptr ? names_of_commands(command) : choices(*positional);
  return fmt::format(
      "    '{}')\n"
      "      options=\"{}\"\n"
      "      words=\"{}\"\n"
      "      case $previous in\n"
      "{}"
      "      esac\n"
      "      ;;\n",
      full_name(command), fmt::join(options, " "),
      values.empty() ? "@files" : fmt::format("{}", fmt::join(values, " ")), bash_values(command));
}

// zsh -------------------------------------------------------------------------------------------------------------

std::string zsh_escaped(const std::string& text) {
  return replaced(replaced(replaced(replaced(text, "'", "'\\''"), "[", "\\["), "]", "\\]"), ":", "\\:");
}

std::string zsh_action(const CLI::Option& option) {
  const std::vector<std::string> values = choices(option);
  if (!values.empty()) return fmt::format(":value:({})", fmt::join(values, " "));
  if (option.get_positional()) return ":input:_isoextract_inputs";
  return takes_file(option) ? ":file:_files" : fmt::format(":{}: ", zsh_escaped(option.get_type_name()));
}

// The choice among the commands of `app`, the first word after its name; no other word comes before it.
std::string zsh_choice(const CLI::App& app) {
  std::string described;
  std::string branches;
  for (const CLI::App* command : commands_of(app)) {
    described += fmt::format("      '{}:{}'\n", command->get_name(), zsh_escaped(command->get_description()));
    if (command->get_name() == "convert") continue;
    branches += fmt::format("    {}) shift words; (( CURRENT-- )); _isoextract_{} ;;\n", command->get_name(),
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

std::string zsh_command(const CLI::App& command) {
  if (!commands_of(command).empty()) {
    return fmt::format("_isoextract_{}() {{\n{}  esac\n}}\n\n", function_name(command), zsh_choice(command));
  }
  std::string out = fmt::format("_isoextract_{}() {{\n  _arguments -s -S", function_name(command));
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) {
      if (option == positional_of(command)) out += fmt::format(" \\\n    '*{}'", zsh_action(*option));
      continue;
    }
    const bool repeatable = option->get_items_expected_max() > 1;
    for (const std::string& word : words_of(*option)) {
      const bool has_equals = takes_value(*option) && word.starts_with("--");
      out += fmt::format(" \\\n    '{}{}{}[{}]{}'", repeatable ? "*" : "", word, has_equals ? "=" : "",
                         zsh_escaped(first_sentence(option->get_description())),
                         takes_value(*option) ? zsh_action(*option) : "");
    }
  }
  return out + "\n}\n\n";
}

// fish ------------------------------------------------------------------------------------------------------------

std::string fish_quoted(const std::string& text) {
  return "'" + replaced(replaced(text, "\\", "\\\\"), "'", "\\'") + "'";
}

std::string fish_option(const CLI::App& command, const CLI::Option& option) {
  std::string line = fmt::format("complete -c isoextract -n '__isoextract_command_is {}'", full_name(command));
  for (const std::string& name : option.get_snames()) line += " -s " + name;
  for (const std::string& name : option.get_lnames()) line += " -l " + name;
  const std::vector<std::string> values = choices(option);
  if (!values.empty()) {
    line += fmt::format(" -x -a '{}'", fmt::join(values, " "));
  } else if (takes_value(option)) {
    line += takes_file(option) ? " -r -F" : " -x";
  }
  return line + " -d " + fish_quoted(first_sentence(option.get_description())) + "\n";
}

std::string fish_positional(const CLI::App& command, const CLI::Option& option) {
  const std::vector<std::string> values = choices(option);
  return fmt::format("complete -c isoextract -n '__isoextract_command_is {}' {} -a '{}'\n", full_name(command),
                     values.empty() ? "-F" : "-f", fmt::join(values.empty() ? demo_names() : values, " "));
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  std::string commands;
  for (const CLI::App* command : all_commands(app)) commands += bash_command(*command);
  return fmt::format(R"(# bash completion of isoextract. Made by 'isoextract generate bash'; do not edit.

_isoextract() {{
  # Words as the shell splits them at spaces only: bash also breaks at ':' and '='.
  local line=${{COMP_LINE:0:COMP_POINT}}
  local current=${{line##*[[:space:]]}}
  local rest=${{line%"$current"}}
  rest=${{rest%"${{rest##*[![:space:]]}}"}}
  local previous=${{rest##*[[:space:]]}}
  local given=$current

  local command=convert first
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
    @files)
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
                     fmt::join(names_of_commands(app), "|"), commands, fmt::join(demo_names(), " "),
                     fmt::join(names_of_commands(app), " "), app.get_version_ptr()->get_name(),
                     fmt::join(quoted_inner_names(app), "|"));
}

std::string zsh_completion(const CLI::App& app) {
  std::string functions;
  for (const CLI::App* command : all_commands(app)) functions += zsh_command(*command);
  return fmt::format(R"(#compdef isoextract
# zsh completion of isoextract. Made by 'isoextract generate zsh'; do not edit.

_isoextract_inputs() {{
  local -a demos=({})
  _alternative 'files:volume:_files' 'demos:demo field:compadd -a demos'
}}

{}_isoextract() {{
{}    convert) shift words; (( CURRENT-- )); _isoextract_convert ;;
    *) _isoextract_convert ;;
  esac
}}

_isoextract "$@"
)",
                     fmt::join(demo_names(), " "), functions, zsh_choice(app));
}

std::string fish_completion(const CLI::App& app) {
  std::string out = fmt::format(R"(# fish completion of isoextract. Made by 'isoextract generate fish'; do not edit.

function __isoextract_command_is
    set -l words (commandline -opc)
    set -l command convert
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
                                fmt::join(names_of_commands(app), " "), fmt::join(quoted_inner_names(app), " "));
  for (const CLI::App* command : commands_of(app)) {
    out += fmt::format("complete -c isoextract -n __isoextract_first_word -a {} -d {}\n", command->get_name(),
                       fish_quoted(first_sentence(command->get_description())));
  }
  out += "complete -c isoextract -n __isoextract_first_word -l version -d 'Show the version and exit'\n";
  for (const CLI::App* command : all_commands(app)) {
    for (const CLI::App* inner : commands_of(*command)) {
      out += fmt::format("complete -c isoextract -n '__isoextract_command_is {}' -f -a {} -d {}\n", full_name(*command),
                         inner->get_name(), fish_quoted(first_sentence(inner->get_description())));
    }
    for (const CLI::Option* option : command->get_options()) {
      out += option->get_positional() ? fish_positional(*command, *option) : fish_option(*command, *option);
    }
  }
  return out;
}

}  // namespace isoextract::cli
