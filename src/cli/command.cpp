#include "cli/command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::cli {

std::vector<std::string> Command::path() const {
  std::vector<std::string> path;
  if (outer_ != nullptr) path = outer_->path();
  if (outer_ != nullptr) path.push_back(name());
  return path;
}

std::string Command::full_name() const { return fmt::format("{}", fmt::join(path(), " ")); }

std::string Command::synopsis() const {
  const std::string name = is_default() ? fmt::format("[{}]", full_name()) : full_name();
  if (inner_.empty()) return fmt::format("isoextract {} {}", name, words_.operands);
  return fmt::format("isoextract {} {} [options]", name, fmt::join(inner_names(), "|"));
}

void Command::add(std::unique_ptr<Command> inner) {
  inner->outer_ = this;
  inner_.push_back(std::move(inner));
}

std::vector<std::string> Command::inner_names() const {
  std::vector<std::string> names;
  for (const auto& inner : inner_) names.push_back(inner->name());
  return names;
}

Command* Command::find(std::string_view name) const {
  for (const auto& inner : inner_) {
    if (inner->name() == name) return inner.get();
  }
  return nullptr;
}

const Command& Command::program() const { return outer_ == nullptr ? *this : outer_->program(); }

bool Command::is_default() const { return outer_ != nullptr && this == &default_command(program()); }

std::optional<HelpDetail> Command::help_asked() const {
  std::optional<HelpDetail> asked;
  for (const Option* option : options().options()) {
    if (option->help() && !option->texts().empty()) asked = option->help();
  }
  return asked;
}

std::string Command::hint_for_default_command_option(std::string_view option) const {
  return fmt::format("{} is an option of {}; {}", option, default_command(program()).name(), help_hint(*this));
}

std::vector<const Command*> all_commands(const Command& program) {
  std::vector<const Command*> all;
  for (const auto& command : program.inner()) {
    all.push_back(command.get());
    for (const auto& inner : command->inner()) all.push_back(inner.get());
  }
  return all;
}

const Command& default_command(const Command& program) { return *program.inner().front(); }

std::string help_hint(const Command& command) {
  return fmt::format("'isoextract {} --help' lists the options", command.full_name());
}

}  // namespace isoextract::cli
