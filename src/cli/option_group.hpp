// How options are declared: by kind, in groups, with a parser that says what is wrong.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "base/error.hpp"
#include "base/words.hpp"
#include "cli/options.hpp"
#include "cli/values.hpp"

namespace isoextract::cli {

// A word of the command line and what it means.
template <class T>
struct Choice {
  std::string name;
  T value;
};

// Declares the options of one group of one command.
class Group {
 public:
  Group(CLI::App& app, std::string name) : app_(app), name_(std::move(name)) {}

  template <class T>
  CLI::Option* value(const std::string& names, const std::string& metavar, std::optional<T>& target,
                     Result<T> (*parse)(std::string_view), const std::string& description) const {
    return declare(names, metavar, description,
                   [&target, parse, names](const std::string& text) { target = parsed(names, parse(text)); });
  }

  template <class T>
  CLI::Option* values(const std::string& names, const std::string& metavar, std::vector<T>& targets,
                      Result<T> (*parse)(std::string_view), const std::string& description) const {
    return declare(names, metavar, description,
                   [&targets, parse, names](const std::string& text) { targets.push_back(parsed(names, parse(text))); })
        ->expected(1, CLI::detail::expected_max_vector_size)
        ->allow_extra_args(false);
  }

  // Of an enum, by its own words.
  template <class E>
  CLI::Option* choice(const std::string& names, std::optional<E>& target, const std::string& description) const {
    std::vector<Choice<E>> choices;
    for (const Word<E>& entry : words_of(E{})) choices.push_back({std::string(entry.word), entry.value});
    return choice(names, target, std::move(choices), description);
  }

  template <class T>
  CLI::Option* choice(const std::string& names, std::optional<T>& target, std::vector<Choice<T>> choices,
                      const std::string& description) const {
    std::vector<std::string> words;
    for (const Choice<T>& c : choices) words.push_back(c.name);
    const std::string metavar = fmt::format("{}", fmt::join(words, "|"));
    return declare(names, metavar, description,
                   [&target, choices = std::move(choices), words, names](const std::string& text) {
                     const auto found = std::find(words.begin(), words.end(), text);
                     if (found == words.end()) throw BadValue(unknown_choice(names, text, words));
                     target = choices[static_cast<std::size_t>(found - words.begin())].value;
                   });
  }

  void flag(const std::string& names, bool& target, const std::string& description) const {
    app_.add_flag(names, target, description)->disable_flag_override()->group(name_);
  }

  // CLI11 puts its help flag first; re-declared here it stands where it is looked for, last.
  void help_flag() const {
    app_.set_help_flag();
    app_.set_help_flag("-h,--help", "Show the options of this command and exit.")->group(name_);
  }

 private:
  static std::string shown_name(const std::string& names) { return names.substr(names.find(',') + 1); }

  static Error unknown_choice(const std::string& names, const std::string& text,
                              const std::vector<std::string>& words) {
    const std::string near = nearest_name(text, words);
    return {ErrorKind::usage,
            fmt::format("{}: expected one of {}, found '{}'", shown_name(names), fmt::join(words, ", "), text),
            near.empty() ? "" : fmt::format("did you mean '{}'?", near)};
  }

  template <class T>
  static T parsed(const std::string& names, Result<T> result) {
    if (result) return std::move(*result);
    Error error = std::move(result.error());
    error.message = fmt::format("{}: {}", shown_name(names), error.message);
    throw BadValue(std::move(error));
  }

  CLI::Option* declare(const std::string& names, const std::string& metavar, const std::string& description,
                       std::function<void(const std::string&)> take) const {
    return app_
        .add_option(names, CLI::callback_t([take = std::move(take)](const CLI::results_t& given) {
                      for (const std::string& text : given) take(text);
                      return true;
                    }),
                    description)
        ->type_name(metavar)
        ->group(name_);
  }

  CLI::App& app_;
  std::string name_;
};

}  // namespace isoextract::cli
