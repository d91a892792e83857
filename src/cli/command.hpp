// A command of the program: its words, its options, what it does. make_program() (commands.hpp) lists them. Parser,
// help, man page and completions walk that tree, and know no command by its name.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "cli/option.hpp"

namespace isoextract::cli {

inline constexpr int kDone = 0;  // the exit code

struct CommandWords {
  std::string name;
  std::string operands;  // of the synopsis, after the name: "INPUT... [options]"
  std::string summary;   // a sentence
};

class Command {
 public:
  explicit Command(CommandWords words) : words_(std::move(words)) {}
  virtual ~Command() = default;
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  [[nodiscard]] const std::string& name() const { return words_.name; }
  [[nodiscard]] const std::string& summary() const { return words_.summary; }
  // As it is written after the program's name: {"simulate", "water"}, "simulate water".
  [[nodiscard]] std::vector<std::string> path() const;
  [[nodiscard]] std::string full_name() const;
  [[nodiscard]] std::string synopsis() const;  // "isoextract info INPUT... [options]"

  // The commands of the program, or those of a command that has several, such as `simulate water`.
  void add(std::unique_ptr<Command> inner);
  [[nodiscard]] const std::vector<std::unique_ptr<Command>>& inner() const { return inner_; }
  [[nodiscard]] std::vector<std::string> inner_names() const;
  [[nodiscard]] Command* find(std::string_view name) const;  // among the inner ones, or nullptr
  [[nodiscard]] const Command& program() const;              // that has all of them
  [[nodiscard]] bool is_default() const;                     // runs where no command is named: the program's first

  // They are declared when they are asked for: a run needs those of one command.
  [[nodiscard]] virtual OptionSet& options() const = 0;
  // Takes back all that was given for them.
  virtual void forget() = 0;
  [[nodiscard]] const Option& help_option() const;

  // What is wrong with the words together, before anything else is looked at.
  [[nodiscard]] virtual Result<void> check_words() const { return {}; }
  // Returns the exit code. `arguments` are all words of the command line.
  [[nodiscard]] virtual Result<int> run(const std::vector<std::string>& arguments) = 0;
  // In place of run(), where the arguments give no options.
  virtual void report_failure(const std::vector<std::string>& /*arguments*/, const Error& /*error*/) {}
  // What to do about an option that the default command has and this one has not.
  [[nodiscard]] virtual std::string hint_for_option_of_default(std::string_view option) const;

 private:
  CommandWords words_;
  Command* outer_ = nullptr;
  std::vector<std::unique_ptr<Command>> inner_;
};

// `Flags` are made of nothing, or of their command.
template <class Flags>
class CommandOf : public Command {
 public:
  using Command::Command;

  [[nodiscard]] OptionSet& options() const final { return flags(); }
  void forget() final { flags_.reset(); }
  [[nodiscard]] Flags& flags() const {
    if constexpr (std::is_constructible_v<Flags, const Command&>) {
      if (!flags_) flags_ = std::make_unique<Flags>(*this);
    } else {
      if (!flags_) flags_ = std::make_unique<Flags>();
    }
    return *flags_;
  }

 private:
  mutable std::unique_ptr<Flags> flags_;
};

// The commands of the program, each followed by its inner ones.
[[nodiscard]] std::vector<const Command*> all_commands(const Command& program);
[[nodiscard]] const Command& default_command(const Command& program);
// "'isoextract info --help' lists the options"
[[nodiscard]] std::string help_hint(const Command& command);

}  // namespace isoextract::cli
