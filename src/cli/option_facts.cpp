// What the documents ask of the declarations in options.cpp.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/options.hpp"

namespace isoextract::cli {

std::string synopsis(const CLI::App& command) {
  const std::string name = full_name(command);
  if (const auto inner = commands_of(command); !inner.empty()) {
    std::vector<std::string> names;
    for (const CLI::App* sub_command : inner) names.push_back(sub_command->get_name());
    return fmt::format("isoextract {} {} [options]", name, fmt::join(names, "|"));
  }
  if (name == "convert") return "isoextract [convert] INPUT... --iso V [-o FILE] [options]";
  if (name == "merge") return "isoextract merge FOLDER";
  if (name == "info") return "isoextract info INPUT... [options]";
  if (name == "verify") return "isoextract verify INPUT --iso V [MESH] [options]";
  if (name == "compare") return "isoextract compare A B [options]";
  if (name == "check") return "isoextract check MESH [options]";
  if (name == "render") return "isoextract render INPUT... [-o FILE] [options]";
  if (name == "bench") return "isoextract bench [INPUT...] [options]";
  if (name == "devices") return "isoextract devices [options]";
  if (name == "stability") return "isoextract stability [options]";
  if (name == "simulate water") return "isoextract simulate water -o FILE [options]";
  if (name == "simulate jet") return "isoextract simulate jet -o FILE [options]";
  if (name == "help") return "isoextract help [TOPIC]";
  return "isoextract generate man|bash|zsh|fish";
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

bool value_is_optional(const CLI::Option& option) {
  return takes_value(option) && option.get_items_expected_min() == 0;
}

std::string spelling(const CLI::Option& option) {
  if (option.get_positional()) {
    return choices(option).empty() ? option.get_type_name() : option.get_name(true);
  }
  std::string names;
  for (const std::string& name : option.get_snames()) names += "-" + name + ", ";
  for (const std::string& name : option.get_lnames()) names += "--" + name + ", ";
  names.resize(names.size() - 2);
  if (!takes_value(option)) return names;
  return fmt::format(fmt::runtime(value_is_optional(option) ? "{} [{}]" : "{} {}"), names, option.get_type_name());
}

std::vector<std::string> choices(const CLI::Option& option) {
  const std::string metavar = option.get_type_name();
  if (metavar.find('|') == std::string::npos) return {};
  return CLI::detail::split(metavar, '|');
}

std::vector<const CLI::Option*> options_in_group(const CLI::App& command, const std::string& group) {
  return command.get_options([&](const CLI::Option* option) { return option->get_group() == group; });
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<const CLI::App*> all_commands(const CLI::App& app) {
  std::vector<const CLI::App*> all;
  for (const CLI::App* command : commands_of(app)) {
    all.push_back(command);
    for (const CLI::App* inner : commands_of(*command)) all.push_back(inner);
  }
  return all;
}

std::string full_name(const CLI::App& command) {
  const CLI::App* outer = command.get_parent();
  const bool is_inner = outer != nullptr && outer->get_parent() != nullptr;
  return is_inner ? fmt::format("{} {}", outer->get_name(), command.get_name()) : command.get_name();
}

}  // namespace isoextract::cli
