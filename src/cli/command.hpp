// A command of the program: its name, its options, its action. make_program() (commands.hpp) builds the
// tree of commands. The parser, help, man page and completions traverse it; none of them depends on a command's name.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "cli/option.hpp"

namespace isoextract::cli {

struct RunFlags;

inline constexpr int kDone = 0;  // the exit code of success

struct CommandWords {
  std::string name;
  std::string operands;  // in the synopsis, after the name: "INPUT... [options]"
  std::string summary;   // one sentence
};

class Command {
 public:
  explicit Command(CommandWords words) : words_(std::move(words)) {}
  virtual ~Command() = default;
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  [[nodiscard]] const std::string& name() const { return words_.name; }
  [[nodiscard]] const std::string& summary() const { return words_.summary; }
  // Returns the names of the outer commands and of this one, without the program: {"simulate", "water"}.
  [[nodiscard]] std::vector<std::string> path() const;
  [[nodiscard]] std::string full_name() const;  // path() joined by spaces: "simulate water"
  [[nodiscard]] std::string synopsis() const;   // "isoextract info INPUT... [options]"

  // Adds a command to the program, or a sub-command such as `simulate water`.
  void add(std::unique_ptr<Command> inner);
  [[nodiscard]] const std::vector<std::unique_ptr<Command>>& inner() const { return inner_; }
  [[nodiscard]] std::vector<std::string> inner_names() const;
  [[nodiscard]] Command* find(std::string_view name) const;  // the inner command with this name, or nullptr
  [[nodiscard]] const Command& program() const;              // the outermost command
  [[nodiscard]] bool is_default() const;                     // the program's first command, which runs if none is named

  // Returns the options; constructs them on the first call, since a run uses the options of one command only.
  [[nodiscard]] virtual OptionSet& options() const = 0;
  // Resets all options to their defaults.
  virtual void forget() = 0;
  // Returns the options about messages and threads, or nullptr if the command has none.
  [[nodiscard]] virtual const RunFlags* run_flags() const { return nullptr; }
  // Returns the help that the command line requests, or nullopt.
  [[nodiscard]] std::optional<HelpDetail> help_asked() const;

  // Checks the parsed values of several options against each other before run().
  [[nodiscard]] virtual Result<void> check_words() const { return {}; }
  // Runs the command and returns the exit code. `arguments` are all words of the command line but the program's name.
  [[nodiscard]] virtual Result<int> run(const std::vector<std::string>& arguments) = 0;
  // Returns whether all ranks of a run call run() (rank_run.hpp); otherwise only rank 0 does.
  [[nodiscard]] virtual bool shares_work() const { return false; }
  // Writes the report that the options request. Called in place of run() if the parser refuses the options.
  virtual void report_failure(const std::vector<std::string>& /*arguments*/, const Error& /*error*/) {}
  // Returns a hint about an option that the default command has and this command lacks.
  [[nodiscard]] virtual std::string hint_for_default_command_option(std::string_view option) const;

 private:
  CommandWords words_;
  Command* outer_ = nullptr;
  std::vector<std::unique_ptr<Command>> inner_;
};

// A command whose options are in a struct `Flags`. If `Flags` has a constructor that takes a `const Command&`, it gets
// this command.
template <class Flags>
class CommandOf : public Command {
 public:
  using Command::Command;

  [[nodiscard]] OptionSet& options() const final { return flags(); }
  void forget() final { flags_.reset(); }
  [[nodiscard]] const RunFlags* run_flags() const final {
    if constexpr (requires(Flags & all) { all.conversion.run; }) {
      return &flags().conversion.run;
    } else if constexpr (requires(Flags & all) { all.run; }) {
      return &flags().run;
    } else {
      return nullptr;
    }
  }
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

// Returns the commands of the program, each followed by its inner commands.
[[nodiscard]] std::vector<const Command*> all_commands(const Command& program);
[[nodiscard]] const Command& default_command(const Command& program);
// Returns "'isoextract info --help' lists the options".
[[nodiscard]] std::string help_hint(const Command& command);

}  // namespace isoextract::cli
