// `isoextract help`: prints an overview, a command's help, or a topic.
#include "cli/command.hpp"
#include "cli/help_topics.hpp"
#include "cli/messages.hpp"
#include "cli/options/run.hpp"

namespace isoextract::cli {
namespace {

std::vector<Choice<std::string>> topic_choices(const Command& program) {
  std::vector<Choice<std::string>> topics;
  for (const std::string& name : help_names(program)) topics.push_back({name, name});
  return topics;
}

struct HelpFlags : OptionSet {
  explicit HelpFlags(const Command& help)
      : topic(in(OptionGroup::input), "TOPIC", topic_choices(help.program()),
              "A command, a group of options, or a subject.") {}

  Value<std::string> topic;
  RunFlags run{*this, RunFlags::Taken::quiet};
};

class HelpCommand final : public CommandOf<HelpFlags> {
 public:
  HelpCommand() : CommandOf({"help", "[TOPIC]", "Explain a command or a topic."}) {}

  Result<int> run(const std::vector<std::string>& /*arguments*/) override {
    TRY(print_to_stdout(flags().topic ? help_of(program(), *flags().topic) : help_overview(program())));
    return kDone;
  }
};

}  // namespace

std::unique_ptr<Command> make_help_command() { return std::make_unique<HelpCommand>(); }

}  // namespace isoextract::cli
